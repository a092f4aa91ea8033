#!/usr/bin/env python3
"""Prints the software bill of materials of Debian packages, in CycloneDX 1.5: bill.py VERSION FILE.deb...

It lists the packages; each library package that they need, directly or indirectly, in the version on this machine, with
which they were built; and compiled-in code: header-only libraries and the web page's libraries from npm.
"""
import hashlib
import json
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
COMPILED_IN = ["libeigen3-dev", "libcli11-dev", "nlohmann-json3-dev", "libboost-dev"]
# License names of machine-readable copyright files, with their different SPDX names.
SPDX = {"Expat": "MIT", "BSD-3-clause": "BSD-3-Clause", "BSD-2-clause": "BSD-2-Clause", "GPL-2": "GPL-2.0-only", "GPL-2+": "GPL-2.0-or-later",
        "GPL-3": "GPL-3.0-only", "GPL-3+": "GPL-3.0-or-later", "LGPL-2.1": "LGPL-2.1-only", "LGPL-2.1+": "LGPL-2.1-or-later",
        "LGPL-2+": "LGPL-2.0-or-later", "LGPL-3+": "LGPL-3.0-or-later"}


def output(*command):
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def installed():
    """Returns {name: (version, architecture, names it depends on)}, also for the names that packages provide."""
    packages, provided = {}, {}
    form = "${Package}\t${Version}\t${Architecture}\t${Provides}\t${Pre-Depends}, ${Depends}\n"
    for line in output("dpkg-query", "-W", "-f", form).splitlines():
        name, version, architecture, provides, depends = line.split("\t")
        packages[name] = (version, architecture, depends)
        for other in names_in(provides):
            provided.setdefault(other[0], name)
    return packages, provided


def names_in(depends):
    """Returns the [[alternatives]] of a Depends field."""
    return [[re.sub(r"[ (:].*", "", choice.strip()) for choice in group.split("|")] for group in depends.split(",") if group.strip()]


def closure(depends, packages, provided):
    needed, waiting = set(), names_in(depends)
    while waiting:
        choices = waiting.pop()
        found = next((provided.get(name, name) if name not in packages else name for name in choices
                      if name in packages or name in provided), None)
        if found and found not in needed:
            needed.add(found)
            waiting += names_in(packages[found][2])
    return needed


def licences_of(name):
    file = pathlib.Path("/usr/share/doc", name, "copyright")
    text = file.read_text(errors="replace") if file.is_file() else ""
    names = re.findall(r"^License: *(\S.*)$", text, re.MULTILINE) if text.startswith("Format:") else []
    return [{"license": {"name": SPDX.get(each, each)}} for each in dict.fromkeys(names)]


def component(name, version, purl, **more):
    return {"type": "library", "bom-ref": purl, "name": name, "version": version, "purl": purl} | more


def debian(name, packages):
    version, architecture, _ = packages[name]
    return component(name, version, f"pkg:deb/debian/{name}@{version.replace('+', '%2B').replace('~', '%7E')}?arch={architecture}",
                     licenses=licences_of(name))


def from_npm():
    lock = json.loads((ROOT / "master/station/page/package-lock.json").read_text())
    for path, facts in lock["packages"].items():
        if path and not facts.get("dev"):
            name = path.removeprefix("node_modules/")
            yield component(name, facts["version"], f"pkg:npm/{name}@{facts['version']}", licenses=[{"license": {"name": facts["license"]}}])


def main():
    version, files = sys.argv[1], [pathlib.Path(name) for name in sys.argv[2:]]
    packages, provided = installed()
    components, dependencies, needed = [], [], set()
    for file in files:
        name, own, architecture, depends = output("dpkg-deb", "-W", "--showformat", "${Package}\t${Version}\t${Architecture}\t${Depends}",
                                                  str(file)).split("\t")
        purl = f"pkg:deb/palpate/{name}@{own.replace('+', '%2B').replace('~', '%7E')}?arch={architecture}"
        direct = closure(depends, packages, provided)
        needed |= direct
        components.append(component(name, own, purl, licenses=[{"license": {"id": "Apache-2.0"}}],
                                    hashes=[{"alg": "SHA-256", "content": hashlib.sha256(file.read_bytes()).hexdigest()}]))
        dependencies.append({"ref": purl, "dependsOn": [debian(each, packages)["bom-ref"] for each in sorted(direct)]})
    components += [debian(name, packages) for name in sorted(needed | {name for name in COMPILED_IN if name in packages})]
    components += from_npm()
    json.dump({"bomFormat": "CycloneDX", "specVersion": "1.5", "version": 1,
               "metadata": {"component": {"type": "application", "name": "palpate", "version": version}},
               "components": components, "dependencies": dependencies}, sys.stdout, indent=1)
    print()


if __name__ == "__main__":
    main()
