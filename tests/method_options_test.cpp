// The rows of the options: what they say agrees with what they do.

#include "orasp/method_options.h"

#include <map>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/catalogue.h"
#include "orasp/model/error.h"

namespace orasp {
namespace {

std::vector<std::span<const OptionSpec>> all_tables() {
  std::vector<std::span<const OptionSpec>> tables = {training_options()};
  for (const Planner& planner : planners()) tables.push_back(planner.options());
  return tables;
}

std::string fault_of(const OptionSpec& option, const std::string& text) {
  Options options;
  try {
    set_option(option, "--it", text, options);
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

const OptionSpec& row_called(std::span<const OptionSpec> table, std::string_view name) {
  for (const OptionSpec& option : table) {
    if (option.name == name) return option;
  }
  ADD_FAILURE() << "no option is called " << name;
  return table.front();
}

TEST(MethodOptions, EveryRowSaysWhatItIsAndHasANameOfItsOwn) {
  for (const std::span<const OptionSpec> table : all_tables()) {
    std::set<std::string_view> names;
    for (const OptionSpec& option : table) {
      SCOPED_TRACE(option.name);
      EXPECT_TRUE(names.insert(option.name).second);
      EXPECT_EQ(option.unit.empty(), std::holds_alternative<FlagOption>(option.kind));
      const std::string help = help_of(option);
      EXPECT_NE(help.find("(default: "), std::string::npos) << help;
      EXPECT_EQ(help.find("{}"), std::string::npos) << help;
      EXPECT_EQ(help.find(": )"), std::string::npos) << help;
      EXPECT_TRUE(help.ends_with(")."));
    }
  }
}

TEST(MethodOptions, AnOptionOfSeveralMethodsIsTheSameInEach) {
  std::map<std::string_view, std::string> helps;
  for (const Planner& planner : planners()) {
    for (const OptionSpec& option : planner.options()) {
      const auto [place, is_new] = helps.emplace(option.name, help_of(option));
      EXPECT_EQ(place->second, help_of(option)) << planner.name << ' ' << option.name;
    }
  }
}

TEST(MethodOptions, WhatIsSetIsWhatIsReadBack) {
  for (const std::span<const OptionSpec> table : all_tables()) {
    for (const OptionSpec& option : table) {
      SCOPED_TRACE(option.name);
      const std::string before = value_of(option, Options());
      std::vector<std::string> texts;
      for (const std::string_view word : words_of(option)) texts.emplace_back(word);
      if (std::holds_alternative<FlagOption>(option.kind)) texts = {"true"};
      if (std::holds_alternative<WholeOption>(option.kind)) texts = {"1", "77"};
      if (std::holds_alternative<WholeListOption>(option.kind)) texts = {"3", "8,1,9"};
      if (std::holds_alternative<RealOption>(option.kind)) texts = {"0.25", "0.75"};
      for (const std::string& text : texts) {
        Options options;
        set_option(option, "--it", text, options);
        EXPECT_EQ(value_of(option, options), text);
        for (const OptionSpec& other : table) {
          if (other.name == option.name) continue;
          EXPECT_EQ(value_of(other, options), value_of(other, Options())) << other.name;
        }
      }
    }
  }
}

TEST(MethodOptions, ValuesThatAreNotAllowedAreRefusedWithWhatIs) {
  const auto sweeps = sweep_options();
  EXPECT_EQ(fault_of(row_called(sweeps, "epsilon"), "0"), "--it: \"0\" is not a number above 0");
  EXPECT_EQ(fault_of(row_called(sweeps, "epsilon"), "nan"),
            "--it: \"nan\" is not a number above 0");
  EXPECT_EQ(fault_of(row_called(sweeps, "initial-value"), "1e"), "--it: \"1e\" is not a number");
  EXPECT_EQ(fault_of(row_called(sweeps, "max-sweeps"), "0"),
            "--it: \"0\" is not a whole number from 1 to 18446744073709551615");
  EXPECT_EQ(fault_of(row_called(sweeps, "sweep-order"), "layer"),
            "--it: \"layer\" is none of layers, textbook; did you mean \"layers\"?");
  const auto training = training_options();
  EXPECT_EQ(fault_of(row_called(training, "discount"), "1.5"),
            "--it: \"1.5\" is not a number from 0 to 1");
  EXPECT_EQ(fault_of(row_called(training, "hidden"), "8,,8"),
            "--it: \"\" is not a whole number from 1 to 65536");
  EXPECT_EQ(fault_of(row_called(training, "batch"), "1000001"),
            "--it: \"1000001\" is not a whole number from 1 to 1000000");
}

TEST(MethodOptions, OptionsComeByNameAndOnlyToTheMethodsThatHaveThem) {
  const Options options =
      options_from("value-iteration", {{"sweep-order", "textbook"}, {"max-sweeps", "3"}});
  EXPECT_EQ(options.value_iteration.order, ValueIterationOptions::Order::Textbook);
  EXPECT_EQ(options.value_iteration.max_sweeps, 3U);
  EXPECT_EQ(options.value_iteration.epsilon, ValueIterationOptions().epsilon);
  EXPECT_EQ(options_from("beam", {{"bound", "parts"}}).bound, BoundKind::Parts);

  const auto refusal = [](std::string_view method, const OptionTexts& given) {
    try {
      static_cast<void>(options_from(method, given, "--"));
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(refusal("dijkstra", {{"bound", "best"}}),
            "--bound belongs to the methods orasp-search, a-star, beam and q-learning, not to "
            "dijkstra");
  EXPECT_EQ(refusal("auto", {{"epsilon", "1"}}),
            "--epsilon belongs to the method value-iteration, not to auto");
  EXPECT_EQ(refusal("auto", {{"speed", "1"}}), "no method has an option --speed");
}

TEST(MethodOptions, HelpSaysWhatMayBeChosenAndWhatHoldsOtherwise) {
  EXPECT_EQ(help_of(row_called(bound_options(), "bound")),
            "The upper bound on what is left: none, connections, sizes, parts, best (default: "
            "best; none is the paper's).");
  EXPECT_EQ(help_of(row_called(sweep_options(), "epsilon")),
            "Stop when no value changed by this much (default: 1e-9).");
  EXPECT_EQ(help_of(row_called(training_options(), "hidden")),
            "Units of the hidden layers (default: two of 128, or of the connections if they are "
            "more; two of 32 over pieces).");
}

}  // namespace
}  // namespace orasp
