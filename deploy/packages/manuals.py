#!/usr/bin/env python3
"""Writes manual pages and bash completions from the --help texts: manuals.py BIN OUT VERSION

BIN: folder of palpate-slave and palpate-master. Creates OUT/slave and OUT/master, each with man/man1/*.1.gz and
bash-completion/completions/*.
"""
import gzip
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests"))
import references  # parses the help texts

COMPLETION = """# Completion of {program}, made from its --help texts.
_{function}() {{
  local word=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD-1]}} options
  case $before in
{choices}
  esac
  case ${{COMP_WORDS[1]}} in
{options}
    *) options="{commands} --help --version" ;;
  esac
  # What is no option is a file: of that `complete -o default` takes care.
  if [[ $word == -* || $COMP_CWORD -eq 1 ]]; then mapfile -t COMPREPLY < <(compgen -W "$options" -- "$word"); fi
}}
complete -o default -F _{function} {program}
"""


def roff(text):
    """Formats text for a manual page, with the program names of the packages."""
    text = text.replace("deploy/certs", "palpate-certs").replace("deploy/scenes", "/usr/share/palpate/scenes")
    text = text.replace("\\", "\\e").replace("-", "\\-").replace("`", "\\(ga")
    return re.sub(r"(?m)^([.'])", r"\\&\1", text)


def example(text):
    return f".nf\n{roff(text)}\n.fi\n"


def option(given):
    argument = "" if given.default == "required" and not given.name.startswith("`-") else f" {given.argument}".rstrip()
    default = f" Default: {given.default.strip('`')}." if given.default not in ("", "required") else ""
    end = "" if given.meaning.endswith(".") or not default else "."
    return f".TP\n.B {roff(given.name.replace('`', ''))}{roff(argument.replace('`', ''))}\n{roff(given.meaning)}{end}{roff(default)}\n"


def footer_of(text):
    """Returns the text behind the options: notes, examples, exit codes."""
    return text[min(text.find(word) for word in ("Example:", "Examples:", "Exit codes:", "\0") if word in text + "\0"):].rstrip("\0").strip()


def notes_of(text):
    """Returns the paragraphs behind the options, without examples and exit codes."""
    paragraphs = text.strip().split("\n\n")
    tables = [i for i, one in enumerate(paragraphs) if re.match("(Positionals|Options|Subcommands):", one.strip())]
    behind = paragraphs[max(tables, default=-1) + 1:]
    return "\n\n".join(one for one in behind if not re.match("(Examples?|Exit codes):", one.strip())).strip()


def manual(program, version, helps):
    top = helps[None]
    lines = [f'.TH {program.upper()} 1 "" "Palpate {version}" "Palpate"\n',
             f".SH NAME\n{program} \\- {roff(top.description.split(': ', 1)[1])}\n",
             f".SH SYNOPSIS\n.B {program}\n.I COMMAND\n[\\fIoptions\\fR]\n.SH COMMANDS\n"]
    for command, help in helps.items():
        if command:
            positional = " ".join(given.name.strip("`") for given in help.options if not given.name.startswith("`-"))
            lines.append(f".SS {program} {command} {roff(positional)}\n{roff(help.description)}.\n")
            lines += [option(given) for given in help.options if "--help" not in given.name and "--version" not in given.name]
            if notes := notes_of(references.help_of(program, command)):
                lines.append(".PP\n" + example(notes))
    footer = footer_of(references.help_of(program))
    examples, _, codes = footer.partition("Exit codes:")
    lines.append(".SH EXAMPLES\n" + example(re.sub(r"^Examples:\n", "", examples).rstrip()))
    lines.append(f".SH EXIT STATUS\n{roff(codes.strip().capitalize())}\n")
    lines.append(f".SH FILES\n/etc/palpate/{program.removeprefix('palpate-')}.conf: what the systemd unit {program} runs.\n")
    return "".join(lines)


def completion(program, helps):
    def words(help):
        return " ".join(name.strip("` ") for given in help.options for name in given.name.split(",") if "-" in name)

    choices = {}
    for help in helps.values():
        for given in help.options:
            values = re.findall(r"`([^`]+)`", given.argument)
            if given.name.startswith("`-") and values:
                choices[given.name.strip("`")] = " ".join(values)
    lines = [f'    {name}) mapfile -t COMPREPLY < <(compgen -W "{values}" -- "$word"); return ;;' for name, values in choices.items()]
    options = [f'    {command}) options="{words(help)}" ;;' for command, help in helps.items() if command]
    return COMPLETION.format(program=program, function=program.replace("-", "_"), choices="\n".join(lines) or "    '') ;;",
                             options="\n".join(options), commands=" ".join(command for command in helps if command))


def certs_manual(version):
    lines = [line.removeprefix("#").removeprefix(" ").rstrip() for line in (ROOT / "deploy/certs").read_text().splitlines()[1:8]]
    first, _, rest = "\n".join(lines).partition("\n")
    return (f'.TH PALPATE-CERTS 1 "" "Palpate {version}" "Palpate"\n.SH NAME\npalpate-certs \\- make certificates for \\-\\-tls\n'
            f".SH DESCRIPTION\n{roff(first)}\n{example(rest)}")


def write(file, text):
    file.parent.mkdir(parents=True, exist_ok=True)
    if file.suffix == ".gz":
        file.write_bytes(gzip.compress(text.encode(), mtime=0))
    else:
        file.write_text(text)


def main():
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    references.BIN = pathlib.Path(sys.argv[1]).resolve()
    out, version = pathlib.Path(sys.argv[2]), sys.argv[3]
    for program in ("palpate-slave", "palpate-master"):
        top = references.parse_help(references.help_of(program))
        helps = {None: top} | {command: references.parse_help(references.help_of(program, command)) for command in top.commands}
        folder = out / program.removeprefix("palpate-")
        write(folder / f"man/man1/{program}.1.gz", manual(program, version, helps))
        write(folder / f"bash-completion/completions/{program}", completion(program, helps))
    write(out / "slave/man/man1/palpate-certs.1.gz", certs_manual(version))


if __name__ == "__main__":
    main()
