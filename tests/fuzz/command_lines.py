#!/usr/bin/python3
# A fuzzer of command lines: random commands, options and values, and files out of a set that has all kinds: scenes with buffers and
# images beside them, assets, JSON, what is broken, links, hard links, read-only files, folders. After each run every file is
# compared with what it was. What must hold:
#
#   - no file changes that is not an output of the command line, and no input changes, also one that is named as an output
#   - outputs that are read-only, or have further names, change with --force only; what is replaced keeps its mode; nothing is left
#   behind
#   - no crash and no hang: an exit status of the manual; one line gives the reason where it is 2 or more
#   - no exit status 0 with an output missing
#
# Options and operands come from `vxs COMMAND --help`, so that new ones are met without a change here. A run depends on its seed and
# its number alone: `--seed S --only N` repeats it.
# SPDX-License-Identifier: GPL-3.0-or-later
import argparse
import base64
import concurrent.futures
import hashlib
import json
import os
import pathlib
import random
import re
import shlex
import shutil
import stat
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "cli"))
import small_scene  # noqa: E402

STATUSES = range(7)
TIMEOUT_S = 120
CRASH = re.compile(rb"Sanitizer|runtime error:|Assertion|terminate called|stack smashing|corrupted|double free")
# what a run costs: values of options that are not given
CHEAP = {"--resolution": "16", "--points": "20", "--runs": "1", "--width": "16", "--height": "16", "--triangles": "1000", "--size": "30",
         "--threads": "2"}
# of a command with sanitizers: leaks are for the unit tests, since OpenGL drivers have some
SANITIZERS = {"ASAN_OPTIONS": "detect_leaks=0", "UBSAN_OPTIONS": "print_stacktrace=1"}
# accepted, so that a command line of bake is one of plan, and not written
NOT_WRITTEN = {("plan", "-o"), ("plan", "--report")}
# values of options that name a folder into which files are written
FOLDERS = ("FOLDER", "DIR")
# what belongs to a scene
BELONGS = {"level.gltf": ("level data.bin", "wall.png", "unread.bin"), "here/level.gltf": ("level data.bin", "wall.png", "unread.bin")}


# --- the set of files -----------------------------------------------------------------------------------------------------------------


def make_set(vxs, folder):
    """All files that commands are given. Names that end in what a file is, so that an operand may be of its kind."""
    run = lambda *args: subprocess.run([vxs, *map(str, args)], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    lights = (("sun", "directional", (0.3, -1, 0.2)), ("lamp", "spot", (0, -1, 0)), ("bulb", "point", (0, -1, 0)))
    gltf = json.loads(small_scene.write(folder / "level.gltf", lights=lights).read_text())
    small_scene.write(folder / "inside.gltf")
    small_scene.write(folder / "open.gltf", open_faces=True)
    small_scene.write(folder / "dark.gltf", lights=())
    (folder / "level data.bin").write_bytes(base64.b64decode(gltf["buffers"][0]["uri"].partition(",")[2]))
    gltf["buffers"][0]["uri"] = "level%20data.bin"
    gltf["buffers"].append({"byteLength": 4, "uri": "unread.bin", "extensions": {"EXT_meshopt_compression": {"fallback": True}}})
    gltf["images"] = [{"uri": "wall.png"}]
    (folder / "level.gltf").write_text(json.dumps(gltf))
    (folder / "wall.png").write_bytes(b"not read by anybody")
    (folder / "unread.bin").write_bytes(b"1234")
    (folder / "points.txt").write_text("0 1 0\n3 4 5 0 1 0\n# none\n")
    run("scene", "city", "--triangles", 1000, "--blocks", 1, "-o", "city.glb")
    run("bake", "level.gltf", "-o", "a.vxs", "--resolution", 16, "--json", "bake.json")
    run("bake", "inside.gltf", "-o", "b.vxs", "--resolution", 32)
    run("bench", "inside.gltf", "-o", "bench.json", "--resolution", 16, "--runs", 1, "--points", 0)
    asset = (folder / "a.vxs").read_bytes()
    (folder / "broken.vxs").write_bytes(asset[:300] + bytes([asset[300] ^ 1]) + asset[301:])
    (folder / "broken.gltf").write_text((folder / "level.gltf").read_text()[:-9])
    (folder / "broken.json").write_text("{")
    (folder / "empty.glb").touch()
    (folder / "old.vxs").write_text("an older file")
    (folder / "ein Bäum.html").write_text("an older page")
    (folder / "-odd.vxs").write_bytes(asset)
    (folder / "readonly.vxs").write_bytes(asset)
    (folder / "readonly.json").write_text("{}")
    for name in ("readonly.vxs", "readonly.json"):
        (folder / name).chmod(0o444)
    (folder / "old.vxs").chmod(0o640)
    os.link(folder / "b.vxs", folder / "hard.vxs")
    os.link(folder / "wall.png", folder / "hard.png")
    for name, target in (("link.vxs", "a.vxs"), ("link.gltf", "level.gltf"), ("link.bin", "level data.bin"), ("link.json", "old.vxs"),
                         ("dangling.vxs", "nobody"), ("loop.json", "loop.json"), ("here", ".")):
        (folder / name).symlink_to(target)
    (folder / "folder").mkdir()
    (folder / "folder" / "deep.json").write_text("{}")


def snapshot(folder):
    """What there is, by its path: inode, kind and mode, owner, and bytes or a link's target."""
    found = {}
    for parent, folders, files in os.walk(folder):
        for name in folders + files:
            path = os.path.join(parent, name)
            status = os.lstat(path)
            content = os.readlink(path) if stat.S_ISLNK(status.st_mode) else ""
            if stat.S_ISREG(status.st_mode):
                with open(path, "rb") as file:
                    content = hashlib.sha256(file.read()).hexdigest()
            found[os.path.relpath(path, folder)] = (status.st_ino, status.st_mode, status.st_uid, status.st_gid, content)
    return found


# --- command lines --------------------------------------------------------------------------------------------------------------------


class Command:
    """What the help of a command says of it."""

    def __init__(self, vxs, name):
        text = subprocess.run([vxs, name, "--help"], check=True, capture_output=True, text=True).stdout
        self.name, synopsis = name, text.splitlines()[0]
        text = re.sub(r"\n {8,}(?=\S)", " ", text)  # what a row says may go on in further lines
        rows = re.findall(r"^  (--?[a-z][\w-]*) (\S*) +(\S.*)$", text, re.MULTILINE)
        assert rows and synopsis.startswith(f"vxs {name} "), f"the help of {name} is not what it was: {text}"
        self.options = {option: (value, "- is standard output" in words) for option, value, words in rows}
        words = iter(re.sub(r"\[[^]]*\](\.\.\.)?", "", synopsis).partition("<")[0].split()[2:])
        self.required, self.operands = [], []
        for word in words:
            if word.startswith("-"):
                self.required.append(word)
                next(words)
            else:
                many = word.endswith("...") or f"[{word} ...]" in synopsis
                self.operands.append((word.rstrip("."), many))


def any_path(chance, names):
    kind = chance.random()
    if kind < 0.7:
        return chance.choice(names)
    if kind < 0.8:
        return chance.choice(["new", "new.vxs", "new.json", "folder/new", "here/new", "./new", "folder/../new", "nobody/new", ""])
    if kind < 0.9:
        return chance.choice(["here/", "./", "folder/../"]) + chance.choice(names)
    return chance.choice(["-", "/dev/null", "/dev/stdout", "/dev/stdin", "/dev/full", "folder", "."])


def value_of(chance, command, option, names):
    """A value of an option: most are good, and all are cheap."""
    value, is_output = command.options[option]
    if chance.random() < 0.03:
        return chance.choice(["", "-1", "0", "nan", "1e999", "x" * 5000, "%s%n", "1,2", "\N{SNOWMAN}", "--json", "-"])
    if "|" in value:
        return chance.choice(value.split("|"))
    if is_output or value in FOLDERS or re.search(r"FILE|OUT|\.\w+$", value):
        return any_path(chance, names)
    if value.startswith("[NAME=]") and chance.random() < 0.3:
        return chance.choice(["sun=", "lamp=", "nobody=", "="]) + chance.choice(["16", "0,-1,0", "1,-1"])
    if value in ("NAME", "PATTERN"):
        return chance.choice(["sun", "lamp", "bulb", "small", "0", "nobody", "one-triangle", "list", "klein-bottle"])
    if "," in value:
        return ",".join(str(chance.choice([-1, 0, 1, 0.5, -20, 20])) for _ in range(6 if value == "MIN,MAX" else 3))
    if value == "BYTES":
        return chance.choice(["1", "60M", "300M", "2G"])
    if option in CHEAP and chance.random() < 0.5:
        return CHEAP[option]
    return chance.choice({"--resolution": ["8", "16", "64"], "--points": ["0", "1", "50"], "--runs": ["1", "2"],
                          "--width": ["16", "40"], "--height": ["16", "40"], "--triangles": ["1000", "3000"], "--size": ["20", "50"],
                          "--level": ["1", "12"], "--blocks": ["1", "3"], "--spots": ["0", "2"]}.get(option, ["1", "2", "3", "5", "0.5"]))


def operand(chance, word, names):
    """Most are of their kind."""
    if word == "KIND":
        return chance.choice(["city", "landscape", "room", "forest", "stress", "stress", "nobody"])
    kinds = {"SCENE": (".gltf", ".glb"), "FILE.vxs": (".vxs",), "BENCH.json": (".json",)}.get(word, ("",))
    fit = [name for name in names if name.endswith(kinds)]
    good = {"SCENE": ["level.gltf", "inside.gltf"], "FILE.vxs": ["a.vxs", "b.vxs"], "BENCH.json": ["bench.json"]}.get(word, fit)
    kind = chance.random()
    return chance.choice(good) if kind < 0.6 else chance.choice(fit) if kind < 0.9 else any_path(chance, names)


class Line:
    """A command line; the paths that it reads and those that it writes."""

    def __init__(self, chance, commands, names):
        command = self.command = chance.choices(commands, [1 if c.name in ("bench", "compare") else 6 for c in commands])[0]
        self.inputs, self.scenes, self.outputs, self.folders, options = [], [], [], [], []
        chosen = [o for o in command.options if chance.random() < 2 / len(command.options) or o in ("--json", "--report", "--force")
                  and chance.random() < 0.3]
        chosen += [o for o in command.required if chance.random() < 0.97 and o not in chosen]
        kind = None
        for word, many in command.operands:
            for _ in range(chance.choice([1, 1, 2]) if many else 1):
                path = operand(chance, word, names)
                kind = path if word == "KIND" else kind
                self.inputs += [path] if word != "KIND" else []
                self.scenes += [path] if word == "SCENE" else []
                options.append(["./" + path if path.startswith("-") and path != "-" else path])
        chosen += [o for o in CHEAP if o in command.options and o not in chosen and not (o == "--resolution" and "--texel" in chosen)
                   and not (command.name == "scene" and (kind == "stress" or o == "--size" and kind not in ("landscape", "forest")))]
        if kind == "stress" and "--case" not in chosen:
            chosen.append("--case")
        for option in chosen:
            value, is_output = command.options[option]
            if not value:
                options.append([option])
                continue
            text = value_of(chance, command, option, names)
            options.append([f"{option}={text}"] if option.startswith("--") and chance.random() < 0.3 else [option, text])
            if is_output:
                self.outputs.append((option, text))
            elif value in FOLDERS:
                self.folders.append(text)
            elif re.search(r"FILE|\.\w+$", value):
                self.inputs.append(text)
        if chance.random() < 0.03:
            options.append([chance.choice(["--help", "--", "--nobody", "-", "more"])])
        chance.shuffle(options)
        self.is_forced = "--force" in chosen
        self.lists_cases = ["--case", "list"] in options or ["--case=list"] in options
        self.arguments = [command.name, *(word for option in options for word in option)]
        self.asks_for_help = any(a.startswith("--help") for a in self.arguments)
        self.stdin = "points.txt" if chance.random() < 0.5 else chance.choice(names)
        self.stdout = chance.choice(names) if chance.random() < 0.1 else None

    def __str__(self):
        return f"vxs {shlex.join(self.arguments)} <{shlex.quote(self.stdin)}" + (f" >>{shlex.quote(self.stdout)}" if self.stdout else "")


# --- a run ----------------------------------------------------------------------------------------------------------------------------


def real_path(folder, path):
    """Where links lead to, as the snapshot calls it."""
    return os.path.relpath(os.path.realpath(os.path.join(folder, path)), os.path.realpath(folder))


def inode(folder, path):
    try:
        status = os.stat(os.path.join(folder, path))
    except (OSError, ValueError):
        return None
    return status.st_ino if stat.S_ISREG(status.st_mode) else None


def execute(vxs, line, folder, temporary):
    """The exit status, None when it hangs, and standard error."""
    def opened(path, flags):
        try:
            return os.open(os.path.join(folder, path), flags | os.O_CLOEXEC)
        except OSError:
            return os.open(os.devnull, os.O_RDWR | os.O_CLOEXEC)

    stdin = opened(line.stdin, os.O_RDONLY)
    stdout = opened(line.stdout or os.devnull, os.O_WRONLY | os.O_APPEND)
    try:
        done = subprocess.run([vxs, *line.arguments], cwd=folder, stdin=stdin, stdout=stdout, stderr=subprocess.PIPE,
                              timeout=TIMEOUT_S, env=os.environ | {"TMPDIR": str(temporary)})
        return done.returncode, done.stderr
    except subprocess.TimeoutExpired as hung:
        return None, hung.stderr or b""
    finally:
        os.close(stdin)
        os.close(stdout)


def faults(line, folder, before, status, errors):
    """What does not hold after a run. before: inputs and outputs as inodes, and the snapshot."""
    inputs, outputs, files = before
    now = snapshot(folder)
    if status is None:
        yield f"no end after {TIMEOUT_S} s"
    elif status not in STATUSES or CRASH.search(errors):
        yield f"exit status {status}"
    said = [text for text in re.sub(rb"\x1b\[[0-9;]*m", b"", errors).splitlines() if text.startswith(b"vxs: error: ")]
    if status is not None and len(said) != (status > 1) and not (status == 1 and len(said) == 1):
        yield f"exit status {status}, and {len(said)} lines of errors"

    allowed = set(outputs)  # real paths
    folders = tuple((real_path(folder, path) + "/").removeprefix("./") for path in line.folders if path)
    appended = files.get(real_path(folder, line.stdout)) if line.stdout else None
    for path in sorted(files.keys() | now.keys()):
        old, new = files.get(path), now.get(path)
        if old == new or (old and stat.S_ISDIR(old[1]) and new and old[1:] == new[1:]):
            continue
        is_appended = old and appended and old[0] == appended[0]
        if path not in allowed and not path.startswith(folders) and path + "/" not in folders and not is_appended:
            yield f"{path} is no output, and was {'changed' if old and new else 'removed' if old else 'made'}"
        elif old and old[0] in inputs and not line.asks_for_help:
            yield f"{path} is an input, and was changed"
        elif old and not is_appended and not line.is_forced and not old[1] & stat.S_IWUSR:
            yield f"{path} is read-only, and was changed"
        elif old and not is_appended and not line.is_forced and [p[0] for p in files.values()].count(old[0]) > 1:
            yield f"{path} has further names, and was changed"
        elif old and (not new or old[1:4] != new[1:4]):
            yield f"{path} was {old[1:4]}, and is {new and new[1:4]}"

    for option, path in line.outputs if status == 0 and not line.asks_for_help and not line.lists_cases else ():
        if path == "-" or path.startswith("/dev/") or (line.command.name, option) in NOT_WRITTEN:
            continue
        real = real_path(folder, path)
        if real not in now or (real in files and files[real][0] == now[real][0]):
            yield f"{option} {path} was not written"


def run_one(vxs, commands, pristine, seed, number, keep):
    """Returns the line, its exit status, and what is wrong with it."""
    chance = random.Random(f"{seed} {number}")
    with tempfile.TemporaryDirectory(prefix="vxs-lines-") as home:
        folder, temporary = os.path.join(home, "files"), os.path.join(home, "temporary")
        os.mkdir(temporary)
        subprocess.run(["cp", "-a", pristine, folder], check=True)
        names = sorted(p for p in snapshot(folder) if os.path.basename(p) not in ("here", "folder"))
        line = Line(chance, commands, names)
        belong = [os.path.join(os.path.dirname(p), b) for p in line.scenes for b in BELONGS.get(os.path.relpath(p or ".", "."), ())]
        inputs = {inode(folder, p) for p in line.inputs + belong if "\0" not in p}
        reads_stdin = line.command.name in ("query", "truth") or {"/dev/stdin", "-"} & set(line.inputs)
        inputs |= {inode(folder, line.stdin)} if reads_stdin else set()
        for device, path in ("/dev/stdin", line.stdin), ("/dev/stdout", line.stdout):
            if device in [p for _, p in line.outputs] and path and inode(folder, path):  # what cannot be opened is /dev/null
                line.outputs.append(("-o", path))
        outputs = [real_path(folder, p) for _, p in line.outputs]
        before = inputs - {None}, outputs, snapshot(folder)
        begin = time.monotonic()
        status, errors = execute(vxs, line, folder, temporary)
        seconds = time.monotonic() - begin
        wrong = list(faults(line, folder, before, status, errors)) + [f"{name} is left in TMPDIR" for name in os.listdir(temporary)]
        if wrong and keep:
            shutil.copytree(home, f"{keep}-{number}", symlinks=True, dirs_exist_ok=True)
    return line, status, wrong, errors, seconds


def main():
    parser = argparse.ArgumentParser(description="Run random command lines, and look whether what must hold does.")
    parser.add_argument("--vxs", default=str(ROOT / "build" / "release" / "vxs"), help="the command")
    parser.add_argument("--seed", default="1", help="other command lines")
    limit = parser.add_mutually_exclusive_group()
    limit.add_argument("--seconds", type=float, help="how long")
    limit.add_argument("--runs", type=int, help="how many")
    limit.add_argument("--only", type=int, metavar="N", help="run N alone, and say all of it")
    parser.add_argument("--keep", metavar="PREFIX", help="copy the folder of a run that went wrong to PREFIX-N")
    options = parser.parse_args()
    vxs = str(pathlib.Path(options.vxs).resolve())
    os.environ.update(SANITIZERS | os.environ)

    with tempfile.TemporaryDirectory(prefix="vxs-lines-") as home:
        pristine = pathlib.Path(home) / "files"
        pristine.mkdir()
        make_set(vxs, pristine)
        overview = subprocess.run([vxs, "--help"], check=True, capture_output=True, text=True).stdout
        names = re.findall(r"^  (\w+) ", overview.partition("commands:")[2], re.MULTILINE)
        commands = [Command(vxs, name) for name in names if name != "help"]
        one = lambda number: (number, *run_one(vxs, commands, pristine, options.seed, number, options.keep))
        if options.only is not None:
            _, line, status, wrong, errors, _ = one(options.only)
            print(f"{line}\nexit status {status}\n{errors.decode(errors='replace')}{chr(10).join(wrong)}")
            return bool(wrong)

        end, number, counts, bad = time.monotonic() + (options.seconds or 60), 0, {}, 0
        workers = len(os.sched_getaffinity(0))
        with concurrent.futures.ThreadPoolExecutor(workers) as pool:
            while number < options.runs if options.runs else time.monotonic() < end:
                batch = range(number, min(number + 8 * workers, options.runs or sys.maxsize))
                number = batch.stop
                for n, line, status, wrong, errors, seconds in pool.map(one, batch):
                    counts[line.command.name, status] = counts.get((line.command.name, status), 0) + 1
                    bad += bool(wrong)
                    if wrong:
                        print(f"run {n}: {line}\n  " + "\n  ".join(wrong) + f"\n  {errors.decode(errors='replace').strip()}", flush=True)
    for name in sorted({name for name, _ in counts}):
        print(f"{name:10}", *(f"{status}: {count}" for (n, status), count in sorted(counts.items(), key=str) if n == name))
    print(f"{number} command lines of seed {options.seed}, {bad} went wrong")
    return bool(bad)


if __name__ == "__main__":
    sys.exit(main())
