// Policy files: what is written is read; anything else is refused in a sentence.

#include "orasp/io/policy_file.h"

#include <array>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/io/digest.h"
#include "orasp/model/error.h"
#include "orasp/model/random.h"

namespace orasp {
namespace {

PolicyFile example() {
  PolicyFile file;
  file.problem_digest = "abc";
  file.problem_name = "a name with \"quotes\"";
  file.trained.reward = -0.1;
  file.trained.policy.scale = 0.25;
  file.trained.policy.adds_reward = true;
  file.trained.policy.layers = {
      {.inputs = 2, .outputs = 3, .weights = {1, 2, 3, 4, 5, 6}, .bias = {0.1F, 0, -1e-30F}},
      {.inputs = 3, .outputs = 2, .weights = {1, 2, 3, 4, 5, 6.5F}, .bias = {7, 8}}};
  file.trained.training = {.episodes = 7,
                           .steps = 8,
                           .updates = 9,
                           .seconds = 1.5,
                           .scale = 0.25,
                           .baseline = {0, -1, -2.1},
                           .hidden = {3},
                           .known_reward = true,
                           .random = 0xfedcba9876543210ULL,
                           .best = {1, 0},
                           .network = {1.5F, 2.5F}};
  return file;
}

/// A policy over pieces: one hidden layer of two units.
PolicyFile over_pieces() {
  PolicyFile file = example();
  file.trained.policy.layers.clear();
  file.trained.policy.pieces = PiecePolicy{.connections = 2, .hidden = {2}, .weights = {}};
  std::vector<float>& weights = file.trained.policy.pieces->weights;
  for (std::size_t i = 0; i < PiecePolicy::num_weights({2}); ++i)
    weights.push_back(0.5F * static_cast<float>(i));
  file.trained.training.hidden = {2};
  return file;
}

std::string message_of(const std::string& bytes) {
  try {
    static_cast<void>(parse_policy(bytes));
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

/// A file with another first line and a checksum that fits it.
std::string with_header(const std::string& from, const std::string& to,
                        const PolicyFile& file = example()) {
  std::string bytes = policy_bytes(file);
  bytes.resize(bytes.size() - 64);
  const std::size_t at = bytes.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  bytes.replace(at, from.size(), to);
  return bytes + detail::sha256_hex(bytes);
}

TEST(PolicyFile, ReadsWhatItWrites) {
  const PolicyFile file = example();
  const std::string bytes = policy_bytes(file);
  const PolicyFile read = parse_policy(bytes);
  EXPECT_EQ(read.problem_digest, file.problem_digest);
  EXPECT_EQ(read.problem_name, file.problem_name);
  EXPECT_EQ(read.trained.policy, file.trained.policy);
  EXPECT_EQ(read.trained.reward, file.trained.reward);
  EXPECT_EQ(read.trained.training.random, file.trained.training.random);
  EXPECT_EQ(read.trained.training.baseline, file.trained.training.baseline);
  EXPECT_EQ(read.trained.training.network, file.trained.training.network);
  EXPECT_EQ(policy_bytes(read), bytes);
}

TEST(PolicyFile, ReadsAPolicyOverPieces) {
  for (const bool adds_reward : {true, false}) {
    PolicyFile file = over_pieces();
    file.trained.policy.adds_reward = adds_reward;
    file.trained.policy.pieces->of_rewards = !adds_reward;
    const std::string bytes = policy_bytes(file);
    const PolicyFile read = parse_policy(bytes);
    EXPECT_EQ(read.trained.policy, file.trained.policy);
    EXPECT_EQ(read.trained.training.network, file.trained.training.network);
    EXPECT_EQ(read.trained.policy.num_connections(), 2U);
    EXPECT_EQ(policy_bytes(read), bytes);
  }
}

TEST(PolicyFile, RefusesPiecesThatDoNotFit) {
  // 20 features in, 2 units, 2 outputs: 42 + 6 weights, 40 of the linear function, 3 of the step.
  ASSERT_EQ(PiecePolicy::num_weights({2}), 91U);
  for (const auto& [from, to, says] : std::vector<std::array<std::string, 3>>{
           {"\"connections\":2", "\"connections\":0", "number of connections"},
           {"\"connections\":2", "\"connections\":-2", "number of connections"},
           {"\"connections\":2", "\"connections\":99999", "number of connections"},
           {"\"connections\":2", "\"connections\":1", "best plan"},
           {"\"connections\":2,\"hidden\":[2]", "\"connections\":2,\"hidden\":[0]", "hidden"},
           {"\"connections\":2,\"hidden\":[2]", "\"connections\":2,\"hidden\":[9]",
            "fewer numbers"},
           {"\"connections\":2,\"hidden\":[2]", "\"connections\":2,\"hidden\":[1]", "more numbers"},
           {"\"connections\":2,\"hidden\":[2]", "\"connections\":2,\"hidden\":[65536,65536]",
            "fewer numbers"},
           {"\"layers\":[]", "\"layers\":[[0,0]]", "both layers and pieces"}}) {
    const std::string message = message_of(with_header(from, to, over_pieces()));
    EXPECT_EQ(message.find("the policy is not as it should be: "), 0U) << to << ": " << message;
    EXPECT_NE(message.find(says), std::string::npos) << to << ": " << message;
  }
}

TEST(PolicyFile, RefusesEveryCutAndEveryFlippedByte) {
  const std::string bytes = policy_bytes(example());
  for (std::size_t size = 0; size < bytes.size(); ++size)
    EXPECT_NE(message_of(bytes.substr(0, size)), "accepted") << size;
  SplitMix64 random(1);
  for (int i = 0; i < 2000; ++i) {
    std::string damaged = bytes;
    damaged[random.below(damaged.size())] ^= static_cast<char>(1 + random.below(255));
    EXPECT_NE(message_of(damaged), "accepted");
  }
  EXPECT_NE(message_of(bytes + "x"), "accepted");
}

TEST(PolicyFile, TakesNoNumberForACountThatIsNone) {
  for (const auto& [from, to] : std::vector<std::pair<std::string, std::string>>{
           {"\"episodes\":7", "\"episodes\":-7"},
           {"\"episodes\":7", "\"episodes\":7.5"},
           {"\"steps\":8", "\"steps\":1e300"},
           {"\"numbers\":2", "\"numbers\":-1"},
           {"\"hidden\":[3]", "\"hidden\":[-3]"},
           {"\"hidden\":[3]", "\"hidden\":3"},
           {"\"layers\":[[2,3]", "\"layers\":[[2,-3]"},
           {"\"best\":[1,0]", "\"best\":[1,4294967296]"},
           {"\"random\":\"18364758544493064720\"", "\"random\":\"-1\""},
           {"\"random\":\"18364758544493064720\"", "\"random\":\"12x\""}}) {
    EXPECT_EQ(message_of(with_header(from, to)).find("the policy is not as it should be: its "), 0)
        << to << ": " << message_of(with_header(from, to));
  }
}

// nlohmann's message repeats the bytes that it could not read, whatever they are.
TEST(PolicyFile, RepeatsNoByteThatIsNotJson) {
  const std::string message = message_of(with_header("\"steps\":8", "\"steps\":\x7f\xff"));
  EXPECT_EQ(message.find("the policy's first line is not JSON from byte "), 0) << message;
}

TEST(PolicyFile, SaysWhatIsWrong) {
  const std::string bytes = policy_bytes(example());
  EXPECT_NE(message_of("PK\x03\x04 an archive of libtorch").find("no policy"), std::string::npos);
  EXPECT_NE(message_of("").find("no policy"), std::string::npos);
  EXPECT_NE(message_of(bytes.substr(0, bytes.size() - 10)).find("checksum"), std::string::npos);
  EXPECT_NE(message_of(bytes.substr(0, 60)).find("cut off"), std::string::npos);
}

/// Written by somebody who knows how to make the checksum fit.
TEST(PolicyFile, TrustsNoSizes) {
  ASSERT_EQ(message_of(with_header("\"steps\":8", "\"steps\":9")), "accepted");
  const std::vector<std::pair<std::string, std::string>> changes = {
      {"[[2,3],[3,2]]", "[[2,3],[4,2]]"},
      {"[[2,3],[3,2]]", "[[2,4],[4,2]]"},
      {"[[2,3],[3,2]]", "[[2,3]]"},
      {"[[2,3],[3,2]]", "[]"},
      {"[[2,3],[3,2]]", "[[65000,65000],[65000,65000]]"},
      {"[[2,3],[3,2]]", "[[99999999999,3],[3,2]]"},
      {"[[2,3],[3,2]]", "[[-1,3],[3,2]]"},
      {"[[2,3],[3,2]]", "7"},
      {"\"numbers\":2", "\"numbers\":1"},
      {"\"numbers\":2", "\"numbers\":3"},
      {"\"numbers\":2", "\"numbers\":4611686018427387905"},
      {"\"baseline\":[0.0,-1.0,-2.1]", "\"baseline\":[0.0]"},
      {"\"best\":[1,0]", "\"best\":[2,0]"},
      {"\"scale\":0.25", "\"scale\":0"},
      {"\"random\":\"18364758544493064720\"", "\"random\":\"x\""},
      {"\"episodes\":7", "\"episodes\":\"7\""},
      {"\"episodes\":7,", ""},
  };
  for (const auto& [from, to] : changes)
    EXPECT_NE(message_of(with_header(from, to)), "accepted") << to;
}

TEST(PolicyFile, RefusesNumbersThatAreNotFinite) {
  PolicyFile file = example();
  file.trained.policy.layers[0].weights[0] = std::numeric_limits<float>::infinity();
  EXPECT_NE(message_of(policy_bytes(file)).find("not finite"), std::string::npos);
}

}  // namespace
}  // namespace orasp
