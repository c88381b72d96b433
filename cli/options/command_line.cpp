#include "cli/options/command_line.h"

#include <algorithm>
#include <sstream>
#include <utility>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "cli/output/text.h"
#include "orasp/model/error.h"

namespace orasp::cli {
namespace {

constexpr std::size_t kHelpWidth = 80;
constexpr std::size_t kHelpIndent = 28;

/// CLI11 sets its groups two empty lines apart.
std::string without_double_gaps(std::string text) {
  for (std::size_t at = text.find("\n\n\n"); at != std::string::npos; at = text.find("\n\n\n", at))
    text.erase(at, 1);
  return text;
}

class HelpFormatter : public CLI::Formatter {
 public:
  std::string make_option(const CLI::Option* option, bool is_positional) const override {
    std::string name =
        is_positional ? option->get_name(true, false) : option->get_name(false, true);
    std::ranges::replace(name, ',', ' ');
    if (!is_positional && option->get_type_size() > 0) name += ' ' + option->get_type_name();
    return help_entry(name, option->get_description());
  }
  std::string make_usage(const CLI::App* app, std::string) const override {
    std::string text = "\nUsage: orasp " + app->get_name();
    for (const CLI::Option* option : app->get_options()) {
      if (option->get_positional()) text += ' ' + option->get_type_name();
    }
    return text + " [OPTIONS]\n";
  }
};

}  // namespace

std::string help_entry(std::string_view name, std::string_view meaning) {
  std::string text = "  " + std::string(name);
  std::size_t column = text.size();
  const auto new_line = [&] {
    text += '\n' + std::string(kHelpIndent, ' ');
    column = kHelpIndent;
  };
  if (column + 2 > kHelpIndent) {
    new_line();
  } else {
    text.resize(kHelpIndent, ' ');
    column = kHelpIndent;
  }
  std::istringstream words{std::string(meaning)};
  for (std::string word; words >> word;) {
    if (column > kHelpIndent && column + 1 + word.size() > kHelpWidth) new_line();
    if (column > kHelpIndent) {
      text += ' ';
      ++column;
    }
    text += word;
    column += word.size();
  }
  return text + '\n';
}

class CommandLine::Parser {
 public:
  explicit Parser(const std::string& name) : app_("", name) {
    app_.formatter(std::make_shared<HelpFormatter>());
    app_.get_formatter()->label("Positionals", "Arguments");
    app_.allow_extras();
    app_.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
  }

  void about(const std::string& text) { app_.description(text); }
  void positional(const std::string& usage, std::string& target, const std::string& help) {
    app_.add_option(bare(usage), target, help)->type_name(usage);
    required(usage, [&target] { return target.empty(); });
  }
  void positionals(const std::string& usage, std::vector<std::string>& targets,
                   const std::string& help) {
    app_.add_option(bare(usage), targets, help)
        ->type_name(usage + "...")
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    required(usage, [&targets] { return targets.empty(); });
  }
  void flag(const std::string& names, const std::string& help, const Setter& set) {
    const auto take = [set](std::int64_t) { set(""); };
    app_.add_flag_function(names, take, help)->disable_flag_override()->group(group_);
  }
  void value(const std::string& names, const std::string& unit, const std::string& help,
             Setter set) {
    const auto take = [=, set = std::move(set)](const std::string& given) {
      if (given.empty()) throw InputError(needs_value(names.substr(names.find("--")), unit));
      set(given);
    };
    app_.add_option_function<std::string>(names, take, help)->type_name(unit)->group(group_);
  }
  void group(const std::string& title) { group_ = title; }
  void footer(const std::string& text) { app_.footer(text); }

  [[nodiscard]] bool parse(const Arguments& arguments) {
    app_.set_help_flag("-h,--help", "Print this help.")->group(group_);  // the last in the list
    try {
      app_.parse(Arguments(arguments.rbegin(), arguments.rend()));
    } catch (const CLI::CallForHelp&) {
      Context(false).print(without_double_gaps(app_.help()));
      return false;
    } catch (const CLI::ParseError& error) {
      refuse_extras();
      throw InputError(sentence(error));
    }
    refuse_extras();
    for (const auto& [name, missing] : required_) {
      if (missing()) throw InputError(fmt::format("{} is missing; {}", name, see_help()));
    }
    return true;
  }

 private:
  static std::string bare(const std::string& usage) {
    const std::size_t begin = usage.find_first_not_of('[');
    return usage.substr(begin, usage.find_first_of("].") - begin);
  }
  void required(const std::string& usage, std::function<bool()> missing) {
    if (usage.front() != '[') required_.emplace_back(usage, std::move(missing));
  }
  [[nodiscard]] static std::string needs_value(const std::string& option, const std::string& unit) {
    return fmt::format("{} needs a value, {}", option, unit);
  }
  [[nodiscard]] std::string see_help() const {
    return fmt::format("`orasp {} --help` lists what it takes", app_.get_name());
  }
  /// An option without its value, a flag with one; otherwise what CLI11 says.
  [[nodiscard]] std::string sentence(const CLI::ParseError& error) const {
    std::string message = error.what();
    const std::string name = message.substr(0, message.find_first_of(": "));
    if (error.get_name() == "ArgumentMismatch" && app_.get_option_no_throw("--" + name) != nullptr)
      return fmt::format("--{} takes no value", name);
    const CLI::Option* const option = app_.get_option_no_throw(name);
    if (option == nullptr) return message;
    return needs_value(name, option->get_type_name());
  }
  void refuse_extras() const {
    const Arguments extras = app_.remaining();
    const auto option =
        std::ranges::find_if(extras, [](const std::string& word) { return word.starts_with('-'); });
    if (option != extras.end()) {
      const std::string name = option->substr(0, option->find('='));
      Arguments known;
      for (const CLI::Option* candidate : app_.get_options()) {
        for (const std::string& long_name : candidate->get_lnames())
          known.push_back("--" + long_name);
      }
      const std::string guess = suggestion(name, known);
      throw InputError(fmt::format("unknown option {}{}", in_quotes(name),
                                   guess.empty() ? "; " + see_help() : guess));
    }
    if (!extras.empty())
      throw InputError(
          fmt::format("unexpected argument {}; {}", in_quotes(extras.front()), see_help()));
  }

  CLI::App app_;
  std::string group_ = "Options";
  std::vector<std::pair<std::string, std::function<bool()>>> required_;
};

CommandLine::CommandLine(const std::string& name) : parser_(std::make_unique<Parser>(name)) {}
CommandLine::~CommandLine() = default;

void CommandLine::about(const std::string& text) {
  parser_->about(text);
}

void CommandLine::positional(const std::string& usage, std::string& target,
                             const std::string& help) {
  parser_->positional(usage, target, help);
  last_words_ = &arguments_.emplace_back(DeclaredArgument{usage, {}}).words;
}

void CommandLine::positionals(const std::string& usage, std::vector<std::string>& targets,
                              const std::string& help) {
  parser_->positionals(usage, targets, help);
  last_words_ = &arguments_.emplace_back(DeclaredArgument{usage, {}}).words;
}

void CommandLine::flag(const std::string& names, bool& target, const std::string& help) {
  flag(names, help, [&target](const std::string&) { target = true; });
}

void CommandLine::flag(const std::string& names, const std::string& help, Setter set) {
  parser_->flag(names, help, set);
  last_words_ = &options_.emplace_back(DeclaredOption{names, "", {}}).words;
}

void CommandLine::turn_off(const std::string& names, bool& target, const std::string& help) {
  flag(names, help, [&target](const std::string&) { target = false; });
}

void CommandLine::quiet_flag(const std::string& help) {
  flag("--quiet", quiet_, help);
}

void CommandLine::value(const std::string& names, const std::string& unit, const std::string& help,
                        Setter set) {
  parser_->value(names, unit, help, std::move(set));
  last_words_ = &options_.emplace_back(DeclaredOption{names, unit, {}}).words;
}

void CommandLine::option(const OptionSpec& row, Setter set) {
  const std::string names = "--" + std::string(row.name);
  if (row.unit.empty()) {
    flag(names, help_of(row), std::move(set));
    return;
  }
  value(names, std::string(row.unit), help_of(row), std::move(set));
  const std::span<const std::string_view> known = words_of(row);
  words({known.begin(), known.end()});
}

void CommandLine::words(std::vector<std::string> known) {
  *last_words_ = std::move(known);
}

void CommandLine::group(const std::string& title) {
  parser_->group(title);
}

void CommandLine::footer(const std::string& text) {
  parser_->footer(text);
}

bool CommandLine::parse(const Arguments& arguments) {
  return parser_->parse(arguments);
}

}  // namespace orasp::cli
