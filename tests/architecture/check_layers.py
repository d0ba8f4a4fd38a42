#!/usr/bin/env python3
"""Fails if an #include goes against the layers of ARCHITECTURE.md.

    check_layers.py [ROOT]

Layer 0 is at the bottom. A module may include itself and modules of the layers below its own, never another module of
its own layer or one above.

    include/hgros/<module>/           public headers, installed
    include/hgros/internal/<module>/  what the templates of public headers need; installed, but no app may include it
    src/include/hgros/<module>/       headers that modules share with those above them; not installed
    src/<module>/                     private to the module

Public headers include neither the last two kinds nor headers of the libraries that are an implementation detail. Faults
go to standard error, one per line.
"""

import pathlib
import re
import sys

LAYERS = [
    ["base"],
    ["codec", "clock", "yaml"],
    ["graph", "transport", "discovery"],
    ["bridge", "services", "config"],
    ["session"],
    ["tf", "params", "record"],
    ["component", "c"],
    ["placement", "testing"],
    ["hgros"],  # the header and the library of the whole project may use every module
]
LAYER_OF = {module: layer for layer, modules in enumerate(LAYERS) for module in modules}

# Headers that no public header may include, because users would have to install and compile them for nothing.
HIDDEN_LIBRARIES = re.compile(r"^(zmq\.h|zmq\.hpp|zmq_addon\.hpp|spdlog/|fmt/|yaml-cpp/|sys/|linux/|"
                              r"(unistd|fcntl|poll|pthread|sched|signal|semaphore)\.h$)")

INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*([<"])([^>"]+)[>"]', re.MULTILINE)
COMMENT = re.compile(r"/\*.*?\*/", re.DOTALL)
SUFFIXES = {".hpp", ".h", ".cpp", ".inl"}


class Owner:
    """The module of a path below ROOT. An app is a client: it is above every module."""

    def __init__(self, module, public=False, shared=False, internal=False, app=False):
        self.module = module
        self.public = public
        self.shared = shared
        self.internal = internal
        self.app = app


def owner_of(path):
    """The owner of a path relative to the root, None where the layers do not apply (tests, examples)."""
    parts = path.parts
    if parts[:2] == ("include", "hgros"):
        internal = parts[2] == "internal"
        folder = parts[3:] if internal else parts[2:]
        return Owner(folder[0] if len(folder) > 1 else "hgros", public=True, internal=internal)
    if parts[:3] == ("src", "include", "hgros"):
        return Owner(parts[3], shared=True)
    if parts[0] == "src" and len(parts) > 2:
        return Owner(parts[1])
    if parts[0] == "bindings":
        return Owner("/".join(parts[:2]), app=True)
    if parts[0] == "apps":
        return Owner(parts[1] if len(parts) > 2 else "", app=True)
    return None


def included_path(root, path, quote, name):
    """The path relative to the root that an #include refers to. None if it is not a file of ours."""
    if name.startswith("hgros/"):
        if name.endswith(".pb.h"):
            return None
        shared = (root / "src" / "include" / name).is_file()
        return pathlib.PurePosixPath("src/include" if shared else "include", name)
    if quote == '"' and (root / path).parent.joinpath(name).is_file():
        return pathlib.PurePosixPath((root / path).parent.joinpath(name).resolve().relative_to(root).as_posix())
    if name.split("/")[0] in LAYER_OF:
        return pathlib.PurePosixPath("src", name)
    if name.split("/")[0] in ("src", "include", "apps", "bindings"):  # Groups of sources need the root as a folder of includes.
        return pathlib.PurePosixPath(name)
    return None


def check_file(root, path):
    """Yields (line, fault) for every include of one file."""
    source = owner_of(path)
    if source is None:
        return
    if not source.app and source.module not in LAYER_OF:
        yield 1, f'"{source.module}" is in no layer; give it one in LAYERS of tests/architecture/check_layers.py'
        return
    text = (root / path).read_text(encoding="utf-8", errors="replace")
    text = COMMENT.sub(lambda match: "\n" * match.group().count("\n"), text)
    for match in INCLUDE.finditer(text):
        quote, name = match.groups()
        line = text.count("\n", 0, match.start()) + 1
        if source.public and HIDDEN_LIBRARIES.match(name):
            yield line, f"a public header includes {name}, which must remain an implementation detail"
            continue
        target_path = included_path(root, path, quote, name)
        target = owner_of(target_path) if target_path else None
        if target is None:
            continue
        if source.app:
            if target.app and target.module != source.module:
                yield line, f"the app {source.module} includes {name} of the app {target.module}"
            elif not target.app and not target.public:
                yield line, f"an app includes {name}, which is private to {target.module}"
            elif target.internal:
                yield line, f"an app includes {name}, which is internal and may change at any time"
            continue
        if target.app:
            yield line, f"{source.module} includes {name} of an app"
        elif target.module not in LAYER_OF:
            yield line, f"{name} belongs to no module of any layer"
        elif source.public and not target.public:
            yield line, f"a public header includes {name}, which is {'not installed' if target.shared else 'private'}"
        elif source.module == target.module:
            continue
        elif not target.public and not target.shared:
            yield line, f"{source.module} includes {name}, which is private to {target.module}"
        elif LAYER_OF[target.module] == LAYER_OF[source.module]:
            yield line, f"{source.module} includes {name} of {target.module}, which is in the same layer ({LAYER_OF[source.module]})"
        elif LAYER_OF[target.module] > LAYER_OF[source.module]:
            yield line, (f"{source.module} (layer {LAYER_OF[source.module]}) includes {name} of {target.module}, "
                         f"which is above it (layer {LAYER_OF[target.module]})")


def check_tree(root):
    """All faults of a tree as "path:line: fault", sorted, and the number of files read."""
    root = pathlib.Path(root).resolve()
    faults = []
    files = 0
    for top in ("include", "src", "apps", "bindings"):
        for file in sorted((root / top).rglob("*")):
            if file.suffix in SUFFIXES and file.is_file():
                files += 1
                path = pathlib.PurePosixPath(file.relative_to(root).as_posix())
                faults += [f"{path}:{line}: {fault}" for line, fault in check_file(root, path)]
    return faults, files


def main():
    faults, files = check_tree(sys.argv[1] if len(sys.argv) > 1 else ".")
    for fault in faults:
        print(fault, file=sys.stderr)
    if files == 0:
        print("No source was found: is this the root of the tree?", file=sys.stderr)
        return 2
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
