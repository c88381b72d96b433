// The program: picks the command and turns exceptions into messages and exit codes. The options of
// a command and what it does stand in commands/command_NAME.cpp.

#include <algorithm>
#include <cstdio>
#include <new>
#include <string>

#include <fmt/format.h>

#include "cli/commands/command_table.h"
#include "cli/exit_codes.h"
#include "cli/on_ranks.h"
#include "cli/options/command_line.h"
#include "cli/output/text.h"
#include "cli/signals.h"
#include "orasp/model/error.h"

namespace orasp::cli {
namespace {

std::string usage() {
  std::string text =
      "orasp plans robotic assembly: proved optimal orders in which to put products together.\n"
      "\nUsage: orasp COMMAND ...\n\nCommands:\n";
  for (const Command& command : commands())
    text += fmt::format("  {:<12}{}\n", command.name, command.summary);
  return text +
         "\nOptions:\n"
         "  -h --help   Print this help.\n"
         "  --version   Print the version.\n"
         "\n`orasp COMMAND --help` explains a command. A first try: `orasp solve hubble`.\n";
}

int dispatch(const Arguments& arguments) {
  // Help and faults of usage come from one process of several.
  const bool silent = !speaks();
  if (arguments.empty()) {
    if (!silent) std::fputs(usage().c_str(), stderr);
    return kWrongInput;
  }
  const std::string& name = arguments.front();
  if (silent && name.starts_with('-')) return kSolved;
  if (name == "--version") {
    Context(false).print("orasp " ORASP_VERSION "\n");
    return kSolved;
  }
  if (name == "--help" || name == "-h") {
    Context(false).print(usage());
    return kSolved;
  }
  Arguments names;
  for (const Command& command : commands()) {
    if (name == command.name) {
      CommandLine line(command.name);
      const CommandWork work = command.declare(line);
      if (among_ranks() && !command.shares) {
        if (silent) return kSolved;
        throw InputError(fmt::format(
            "{} does its work in one process: start it without mpirun (solve and compare share "
            "theirs)",
            name));
      }
      const Arguments rest(arguments.begin() + 1, arguments.end());
      const auto asks_help = [](const std::string& word) {
        return word == "--help" || word == "-h";
      };
      if (silent && std::ranges::any_of(rest, asks_help)) return kSolved;
      const bool asked = line.parse(rest);
      return asked ? work(Context(line.quiet() || silent)) : kSolved;
    }
    names.emplace_back(command.name);
  }
  const bool is_option = name.starts_with('-');
  if (is_option) names = {"--help", "--version"};
  throw InputError(
      fmt::format("unknown {} {}{}", is_option ? "option" : "command", in_quotes(name),
                  nearest(name, names) ? suggestion(name, names) : "; `orasp --help` lists them"));
}

}  // namespace
}  // namespace orasp::cli

int main(int argc, char** argv) {
  using namespace orasp::cli;
  try {
    prepare_streams();
    return dispatch(Arguments(argv + std::min(argc, 1), argv + argc));
  } catch (const orasp::InputError& error) {
    if (!speaks()) return kSolved;
    print_error(error.what());
    return kWrongInput;
  } catch (const std::bad_alloc&) {
    print_error("out of memory; --memory-limit stops a method before that");
  } catch (const std::exception& error) {
    print_error(fmt::format("internal error: {}", error.what()));
  } catch (...) {
    print_error("internal error of an unknown kind");
  }
  return kInternalError;
}
