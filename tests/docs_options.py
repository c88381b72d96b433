"""The parts of the documentation that are written from the program's helps: the tables of options in docs/cli.md and the
section OPTIONS of the manual page docs/orasp.1.

In docs/cli.md such a part stands between `<!-- options of COMMAND -->` and `<!-- end of options -->`; a colon and a
title behind COMMAND choose one group of the help; the names of the methods stand between `<!-- methods -->` and
`<!-- end of methods -->`; in the manual page between the remarks `options` and `end of options`. docs_test.py compares
them with the helps, and writes them with --update.
"""
import re
from typing import NamedTuple

# Groups of options that many commands share. They are described once, as `orasp solve` has them.
SHARED = ("Changes to the problem", "Limits", "Output")


class Option(NamedTuple):
    group: str
    names: list
    unit: str
    meaning: str
    default: str


def options_of(help_text):
    """The options that a help lists, in its order, but for --help."""
    found = []
    group = ""
    body = help_text.split("\nUsage:", 1)[1]
    for title, block in re.findall(r"^([A-Z][^\n]*):\n((?:  [^\n]*\n?)+)", body, re.MULTILINE):
        group = title
        for entry in re.findall(r"^  (-\S[^\n]*\n?(?:   [^\n]*\n?)*)", block, re.MULTILINE):
            words = " ".join(entry.split())
            match = re.match(r"((?:--?[\w-]+ )*--?[\w-]+)(?: ([A-Z][A-Z,.|]*))? (.*)", words)
            names, unit, meaning = match.groups()
            if names == "-h --help":
                continue
            default = (re.findall(r"( ?\(default: ((?:[^()]|\([^()]*\))*)\))", meaning) or [("", "")])[-1]
            text = meaning.replace(default[0], "")
            found.append(Option(group, names.split(), unit or "", text, default[1]))
    return found


def of_command_alone(options, shared):
    """Those that are not described with the shared ones, or have another default than there."""
    known = {option.names[-1]: option.default for option in shared if option.group in SHARED}
    return [option for option in options
            if option.group not in SHARED or known.get(option.names[-1]) != option.default]


def with_methods(option):
    """The meaning, with the methods in front where the option belongs to some."""
    return f"{option.group.removeprefix('Of ')}: {option.meaning}" if option.group.startswith("Of ") else option.meaning


# ---------------------------------------------------------------------------------------------------------------------
# docs/cli.md

def table(options):
    lines = ["| option | default | meaning |", "|---|---|---|"]
    for option in options:
        names = ", ".join(f"`{name}`" for name in option.names[:-1] + [f"{option.names[-1]} {option.unit}".strip()])
        cells = [names, option.default, with_methods(option).rstrip(".")]
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return "\n".join(lines) + "\n"


def method_lists(help_text):
    """The names of the methods, as the help lists them."""
    def names(title):
        block = help_text.split(f"\n{title}:\n", 1)[1].split("\n\n", 1)[0]
        return ", ".join(f"`{name}`" for name in re.findall(r"^  (\S+)", block, re.MULTILINE))
    return f"* one robot: {names('Methods')}\n* several robots: {names('Methods for fleets')}\n"


def names_below(title, text):
    """First words of the lines indented by two below a title, to the next empty line."""
    block = text.split(f"\n{title}\n", 1)[1].split("\n\n", 1)[0]
    return re.findall(r"^  (\S+)", block, re.MULTILINE)


def refreshed_page(text, helps):
    """docs/cli.md with its tables written anew; `helps`: the help of each command, by name."""
    shared = options_of(helps["solve"])

    def rewritten(match):
        name, _, group = match[2].partition(": ")
        options = options_of(helps[name])
        chosen = ([option for option in options if option.group == group] if group
                  else of_command_alone(options, shared))
        return f"{match[1]}\n{table(chosen)}{match[3]}"

    text = re.sub(r"(<!-- options of ([^>]*?) -->)\n.*?(<!-- end of options -->)", rewritten, text, flags=re.DOTALL)
    return re.sub(r"(<!-- methods -->\n).*?(<!-- end of methods -->)",
                  lambda match: match[1] + method_lists(helps["solve"]) + match[2], text, flags=re.DOTALL)


# ---------------------------------------------------------------------------------------------------------------------
# docs/orasp.1

def roff(text):
    return text.replace("\\", "\\e").replace("-", "\\-")


def manual_entries(options):
    text = ""
    for option in options:
        names = "\\fR, \\fB".join(roff(name) for name in option.names)
        unit = f" \\fI{roff(option.unit)}\\fR" if option.unit else ""
        default = f" (default: {option.default})" if option.default else ""
        text += f".TP\n\\fB{names}\\fR{unit}\n{roff(with_methods(option).rstrip('.') + default)}.\n"
    return text


def refreshed_manual(text, helps):
    """docs/orasp.1 with its options written anew."""
    shared = options_of(helps["solve"])
    section = ""
    for name, help_text in helps.items():
        entries = manual_entries(of_command_alone(options_of(help_text), shared))
        section += f".SS Of {name}\n{entries}" if entries else ""
    for group in SHARED:
        owners = [name for name, help_text in helps.items()
                  if any(option.group == group for option in options_of(help_text))]
        section += f".SS {group}: {', '.join(owners)}\n"
        section += manual_entries(option for option in shared if option.group == group)
    return re.sub(r'(\.\\" options[^\n]*\n).*?(\.\\" end of options\n)', lambda match: match[1] + section + match[2], text,
                  flags=re.DOTALL)
