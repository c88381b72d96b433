#include "orasp/io/policy_file.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "orasp/io/detail/json_text.h"
#include "orasp/io/detail/policy_bytes.h"
#include "orasp/io/problem_json.h"
#include "orasp/model/detail/wording.h"
#include "orasp/model/error.h"

namespace orasp {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kBegin = "{\"format\":\"orasp-policy/1\"";
constexpr std::size_t kMostUnits = 65'536;

Json header_of(const PolicyFile& file) {
  Json layers = Json::array();
  for (const DenseLayer& layer : file.trained.policy.layers)
    layers.push_back({layer.inputs, layer.outputs});
  const TrainingState& training = file.trained.training;
  Json header = {
      {"format", "orasp-policy/1"},
      {"problem_digest", file.problem_digest},
      {"problem", file.problem_name},
      {"reward", std::isfinite(file.trained.reward) ? Json(file.trained.reward) : Json()},
      {"layers", std::move(layers)},
      {"scale", file.trained.policy.scale},
      {"adds_reward", file.trained.policy.adds_reward},
      {"training",
       {{"episodes", training.episodes},
        {"steps", training.steps},
        {"updates", training.updates},
        {"seconds", training.seconds},
        {"scale", training.scale},
        {"baseline", training.baseline},
        {"hidden", training.hidden},
        {"known_reward", training.known_reward},
        {"random", fmt::to_string(training.random)},
        {"best", training.best},
        {"numbers", training.network.size()}}}};
  if (const auto& pieces = file.trained.policy.pieces)
    header["pieces"] = {{"connections", pieces->connections}, {"hidden", pieces->hidden}};
  if (file.trained.policy.of_states) header["values"] = "states";
  return header;
}

/// A count as it must stand in the first line. nlohmann's own conversion would take -1 or 1e300 for
/// some count.
std::uint64_t count_of(const Json& value, std::string_view what) {
  if (!value.is_number_unsigned())
    throw InputError(fmt::format("its {} is not a whole number of 0 or more", what));
  return value.get<std::uint64_t>();
}

template <class Number>
std::vector<Number> counts_below(std::uint64_t limit, const Json& list, std::string_view what) {
  if (!list.is_array()) throw InputError(fmt::format("its {} is not a list", what));
  std::vector<Number> counts;
  for (const Json& value : list) {
    const std::uint64_t count = count_of(value, what);
    if (count >= limit) throw InputError(fmt::format("its {} does not fit its layers", what));
    counts.push_back(static_cast<Number>(count));
  }
  return counts;
}

/// The state of the random numbers: a decimal text, since a JSON number may not hold 64 bits.
std::uint64_t random_state_of(const std::string& text) {
  std::uint64_t state = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), state);
  if (error != std::errc() || end != text.data() + text.size())
    throw InputError("its state of the random numbers is not a whole number of 64 bits");
  return state;
}

PiecePolicy pieces_from(const Json& fields, detail::FloatReader& reader) {
  PiecePolicy pieces;
  pieces.connections = count_of(fields.at("connections"), "number of connections");
  if (pieces.connections == 0 || pieces.connections > kMostUnits)
    throw InputError("its number of connections is not one of a problem");
  pieces.hidden =
      counts_below<std::size_t>(kMostUnits + 1, fields.at("hidden"), "list of hidden layers");
  if (std::ranges::find(pieces.hidden, 0U) != pieces.hidden.end())
    throw InputError("its list of hidden layers has an empty one");
  pieces.weights = reader.take(PiecePolicy::num_weights(pieces.hidden));
  return pieces;
}

PolicyFile from_header(const Json& header, detail::FloatReader& reader) {
  PolicyFile file;
  file.problem_digest = header.at("problem_digest").get<std::string>();
  file.problem_name = header.at("problem").get<std::string>();
  if (!header.at("reward").is_null()) file.trained.reward = header.at("reward").get<double>();
  file.trained.policy.scale = header.at("scale").get<double>();
  file.trained.policy.adds_reward = header.at("adds_reward").get<bool>();
  if (!(file.trained.policy.scale > 0) || !std::isfinite(file.trained.policy.scale))
    throw InputError("its scale is not a number above 0");
  for (const Json& shape : header.at("layers")) {
    DenseLayer layer;
    layer.inputs = count_of(shape.at(0), "size of a layer");
    layer.outputs = count_of(shape.at(1), "size of a layer");
    const bool fits = file.trained.policy.layers.empty() ||
                      file.trained.policy.layers.back().outputs == layer.inputs;
    if (!fits || layer.inputs > kMostUnits || layer.outputs > kMostUnits)
      throw InputError("its layers do not fit together");
    layer.weights = reader.take(layer.inputs * layer.outputs);
    layer.bias = reader.take(layer.outputs);
    file.trained.policy.layers.push_back(std::move(layer));
  }
  Policy& policy = file.trained.policy;
  if (header.contains("pieces")) {
    if (!policy.layers.empty()) throw InputError("it has both layers and pieces");
    policy.pieces = pieces_from(header.at("pieces"), reader);
    policy.pieces->of_rewards = !policy.adds_reward;
  } else {
    policy.of_states = header.contains("values");
    if (policy.of_states && header.at("values") != "states")
      throw InputError("its network values neither actions nor states");
    if (policy.layers.empty() ||
        policy.layers.back().outputs != (policy.of_states ? 1 : policy.layers.front().inputs))
      throw InputError("its layers do not fit together");
  }
  const Json& fields = header.at("training");
  TrainingState& training = file.trained.training;
  training.episodes = count_of(fields.at("episodes"), "number of episodes");
  training.steps = count_of(fields.at("steps"), "number of steps");
  training.updates = count_of(fields.at("updates"), "number of updates");
  training.seconds = fields.at("seconds").get<double>();
  training.scale = fields.at("scale").get<double>();
  training.baseline = fields.at("baseline").get<std::vector<double>>();
  training.hidden =
      counts_below<std::size_t>(kMostUnits + 1, fields.at("hidden"), "list of hidden layers");
  training.known_reward = fields.at("known_reward").get<bool>();
  training.random = random_state_of(fields.at("random").get<std::string>());
  const std::size_t connections = file.trained.policy.num_connections();
  training.best = counts_below<ConnectionIndex>(connections, fields.at("best"), "best plan");
  training.network = reader.take(count_of(fields.at("numbers"), "number of numbers"));
  reader.end();
  const auto& baseline = training.baseline;
  if (!(training.scale > 0) || (!baseline.empty() && baseline.size() != connections + 1))
    throw InputError("its training does not fit its layers");
  return file;
}

}  // namespace

std::string policy_bytes(const PolicyFile& file) {
  std::string bytes = header_of(file).dump(-1, ' ', false, Json::error_handler_t::replace) + '\n';
  for (const DenseLayer& layer : file.trained.policy.layers) {
    detail::append_floats(bytes, layer.weights);
    detail::append_floats(bytes, layer.bias);
  }
  if (file.trained.policy.pieces) detail::append_floats(bytes, file.trained.policy.pieces->weights);
  detail::append_floats(bytes, file.trained.training.network);
  return detail::sealed(std::move(bytes));
}

PolicyFile parse_policy(std::string_view bytes) {
  if (!bytes.starts_with(kBegin)) {
    throw InputError(
        "this is no policy of `orasp train`: it does not begin with "
        "{\"format\":\"orasp-policy/1\"");
  }
  const auto [line, numbers] = detail::opened(bytes);
  try {
    detail::FloatReader reader(numbers);
    return from_header(Json::parse(line), reader);
  } catch (const Json::parse_error& error) {  // whose own words repeat bytes of the file
    throw InputError(
        fmt::format("the policy's first line is not JSON from byte {} on", error.byte));
  } catch (const Json::exception& error) {
    throw InputError(std::string("the policy's first line is not as it should be: ") +
                     error.what());
  } catch (const InputError& error) {
    throw InputError(std::string("the policy is not as it should be: ") + error.what());
  }
}

void require_trained_on(const Problem& problem, const PolicyFile& policy, std::string_view file) {
  const std::string digest = problem_digest(problem);
  if (policy.problem_digest == digest) return;
  throw InputError(fmt::format(
      "{} was trained on another problem than this one: on {} with digest {}..., not on {} with "
      "{}..., objective, limits and "
      "direction included",
      file, detail::in_quotes(policy.problem_name), policy.problem_digest.substr(0, 12),
      detail::in_quotes(problem.name()), digest.substr(0, 12)));
}

}  // namespace orasp
