# No input is ever an output, no two outputs are one file, and a file that is replaced keeps what it had, or is left alone.
# SPDX-License-Identifier: GPL-3.0-or-later
import base64
import errno
import hashlib
import json
import os
import re
import shutil
import stat
import struct
import subprocess
import tempfile

import pytest

import small_scene
from test_faults import fault_library, faulty, one_error_line  # noqa: F401

SMALL = ("--resolution", "64")
BENCH = ("--resolution", "64", "--runs", "1", "--points", "0")

# what a command reads in a folder that `files` makes, and where it writes: -o comes first where it must be given
SCENE = ("level.gltf", "level data.bin", "wall.png", "unread.bin")
COMMANDS = {
    "bake": (("bake", "level.gltf", *SMALL), SCENE, ("-o", "--report", "--json")),
    "plan": (("plan", "level.gltf", *SMALL), SCENE, ("--json", "-o", "--report")),
    "info": (("info", "a.vxs"), ("a.vxs",), ("--json",)),
    "validate": (("validate", "a.vxs"), ("a.vxs",), ("--json",)),
    "view": (("view", "level.gltf", "a.vxs", "--page", "page", "--bake-report", "bake.json"), (*SCENE, "a.vxs", "page", "bake.json"), ("-o",)),
    "compare": (("compare", "level.gltf", "a.vxs", "--points", "10", "--bake-report", "bake.json"),
                (*SCENE, "a.vxs", "bake.json"), ("--json",)),
    "bench": (("bench", "level.gltf", *BENCH, "--against", "bench.json"), (*SCENE, "bench.json"), ("-o",)),
    "report": (("report", "bench.json"), ("bench.json",), ("-o",)),
    "render": (("render", "level.gltf", "a.vxs", "--width", "16", "--height", "16"), (*SCENE, "a.vxs"), ("-o", "--json", "--csv", "--plot")),
    "health": (("health", "level.gltf"), SCENE, ("--json",)),
    "mend": (("mend", "level.gltf"), SCENE, ("-o", "--json")),
    "scene": (("scene", "stress", "--case", "one-triangle"), (), ("-o",)),
}


@pytest.fixture(scope="module")
def made(vxs, tmp_path_factory):
    """A scene with a buffer, an image that no mask needs and a buffer that is never read beside it; and what was baked and measured of it."""
    folder = tmp_path_factory.mktemp("files")
    gltf = json.loads(small_scene.write(folder / "level.gltf").read_text())
    (folder / "level data.bin").write_bytes(base64.b64decode(gltf["buffers"][0]["uri"].partition(",")[2]))
    gltf["buffers"][0]["uri"] = "level%20data.bin"
    gltf["buffers"].append({"byteLength": 4, "uri": "unread.bin", "extensions": {"EXT_meshopt_compression": {"fallback": True}}})
    gltf["images"] = [{"uri": "data:image/png;base64,AAAA"}, {"uri": "wall.png"}]
    (folder / "level.gltf").write_text(json.dumps(gltf))
    (folder / "wall.png").write_bytes(b"not read")
    (folder / "page").write_text("<!--vxs:level:1-->")
    (folder / "unread.bin").write_bytes(b"1234")
    vxs("bake", folder / "level.gltf", "-o", folder / "a.vxs", *SMALL, "--json", folder / "bake.json")
    vxs("bench", folder / "level.gltf", "-o", folder / "bench.json", *BENCH)
    return folder


@pytest.fixture
def files(made, tmp_path, monkeypatch):
    """A copy, in the folder where commands run."""
    shutil.copytree(made, tmp_path / "files")
    monkeypatch.chdir(tmp_path / "files")
    return tmp_path / "files"


def state(folder):
    """All that is there: names, bytes, modes."""
    return {p.name: (p.lstat().st_mode, hashlib.sha256(p.read_bytes()).hexdigest() if p.is_file() else "") for p in folder.iterdir()}


def arguments(command, outputs):
    """A command line that writes these, and what else it must."""
    line, _, options = COMMANDS[command]
    must = {"-o": "new"} if options[0] == "-o" else {}
    return [*line, *(word for option in (must | outputs).items() for word in option)]


@pytest.mark.parametrize("command, option", [(c, o) for c, (_, _, options) in COMMANDS.items() for o in options])
def test_no_input_is_an_output(vxs, files, command, option):
    before = state(files)
    for name in COMMANDS[command][1]:
        done = vxs(*arguments(command, {option: name}), status=2)
        assert one_error_line(done) and not done.stdout
        assert re.search(f"{option} {name}: (is the input itself, |'.png' is the extension of other files)", done.stderr)
    assert state(files) == before


@pytest.mark.parametrize("name, says", [("level data.bin", "buffer 0 of 'level.gltf'"), ("unread.bin", "buffer 1 of 'level.gltf'"),
                                        ("wall.png", "image 1 of 'level.gltf'"), ("level.gltf", "SCENE")])
def test_the_message_says_what_reads_the_file(vxs, files, name, says):
    assert says in vxs("render", "level.gltf", "a.vxs", "-o", name, status=2).stderr


def test_a_texture_that_is_not_there_is_an_input(vxs, files):
    (files / "wall.png").unlink()
    vxs("render", "level.gltf", "a.vxs", "-o", "wall.png", status=2)
    assert not (files / "wall.png").exists()


def test_inputs_by_other_names(vxs, files):
    """Through symbolic and hard links, of files and of folders."""
    (files / "link").symlink_to("wall.png")
    os.link(files / "wall.png", files / "hard")
    (files / "here").symlink_to(".")
    before = state(files)
    for name in ("link", "hard", "./wall.png", "here/wall.png", "here/../files/wall.png", files / "wall.png", "here/link"):
        assert "is the input itself" in vxs("render", "level.gltf", "a.vxs", "-o", name, "--force", status=2).stderr
    assert "is the input itself" in vxs("bake", "here/level.gltf", "-o", "level data.bin", *SMALL, status=2).stderr
    assert state(files) == before


def test_standard_streams_lead_to_inputs(vxs_path, files):
    """Standard output appends to what is read, also when it holds nothing but a report; standard input is what is written."""
    (files / "points").write_text("0 1 0\n")
    before = state(files)
    for line, input, output in ((("info", "a.vxs"), None, "a.vxs"), (("info", "a.vxs", "--json", "-"), None, "a.vxs"),
                                (("mend", "level.gltf", "-o", "-"), None, "wall.png"), (("query", "a.vxs"), "points", "points"),
                                (("truth", "level.gltf", "--sun", "0,-1,0"), "points", "points"),
                                (("bake", "level.gltf", "-o", "/dev/stdin", *SMALL), "level.gltf", os.devnull),
                                (("bake", "/dev/stdin", "-o", "level.gltf", *SMALL), "level.gltf", os.devnull)):
        with open(input or os.devnull) as given, open(output, "a") as taken:
            done = subprocess.run([vxs_path, *line], stdin=given, stdout=taken, stderr=subprocess.PIPE, text=True, timeout=60)
        assert done.returncode == 2 and one_error_line(done) and "the input itself" in done.stderr
    assert state(files) == before


# --- two outputs ----------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("exists", [False, True])
@pytest.mark.parametrize("other", ["b", "./b", "d/../b", "here/b"])
def test_two_outputs_are_two_files(vxs, files, other, exists):
    (files / "d").mkdir()
    (files / "here").symlink_to(".")
    if exists:
        (files / "b").write_text("old")
    before = state(files)
    for line in (arguments("bake", {"-o": "b", "--report": other}), arguments("mend", {"-o": other, "--json": "b"})):
        done = vxs(*line, status=2)
        assert one_error_line(done) and "are one file: expected two names" in done.stderr
    assert state(files) == before
    vxs(*arguments("bake", {"-o": "d/b", "--report": "b"}))


def test_devices_are_any_number_of_files(vxs, files):
    vxs(*arguments("bake", {"-o": "/dev/null", "--report": "/dev/null", "--json": "/dev/null"}))


# --- folders into which files are written ------------------------------------------------------------------------------------------------

DRAW = ("render", "level.gltf", "a.vxs", "--width", "16", "--height", "16", "--fog", "0.05", "--quiet")


def test_passes_are_no_inputs(vxs, files):
    """Neither by a link in the folder, nor by a link to the folder, whatever a picture is called; what is no picture of it may lie there."""
    (files / "path.txt").write_text("0 2 5 0 0 0\n5 2 0 0 0 0\n")
    (files / "p").mkdir()
    (files / "here").symlink_to("p")
    shutil.copy("level.gltf", "moving.gltf")
    for name, input in (("depth", "level.gltf"), ("lit-0-sun", "level data.bin"), ("albedo", "a.vxs"), ("light", "path.txt"), ("normal", "moving.gltf"),
                        ("airlight", "unread.bin"), ("lights", "wall.png")):
        for folder in ("p", "./p/", "here"):
            link = files / "p" / f"{name}.png"
            link.symlink_to(f"../{input}")
            before = state(files)
            done = vxs(*DRAW, "-o", "x.png", "--passes", folder, "--moving", "moving.gltf", "--path", "path.txt", "--frames", "1", status=2)
            assert one_error_line(done) and f"--passes {folder}: {name}.png of it is the input itself, " in done.stderr
            assert state(files) == before
            link.unlink()
    (files / "p" / "other.png").symlink_to("../path.txt")
    vxs(*DRAW, "-o", "x.png", "--passes", "p", "--path", "path.txt", "--frames", "1")
    assert (files / "path.txt").read_text().startswith("0 2 5 0 0 0\n")


def test_passes_are_no_other_outputs(vxs, files):
    """Every picture that passes write is one that no other output may be, there or not; nor are two of them one file."""
    vxs(*DRAW, "-o", "x.png", "--passes", "p")
    pictures = sorted(path.name for path in (files / "p").iterdir())
    assert {"depth.png", "lit-0-sun.png", "airlight.png"} <= set(pictures)
    for exists in (True, False):
        if not exists:
            shutil.rmtree("p")
            (files / "p").mkdir()
        before = state(files / "p"), state(files)
        for name in pictures:
            done = vxs(*DRAW, "-o", f"p/{name}", "--passes", "p", status=2)
            assert one_error_line(done) and f"-o p/{name}: is a file that --passes p may write, too: expected another name" in done.stderr
        for option, name in (("--json", "light.png"), ("--plot", "depth.png"), ("--csv", "normal.png")):
            assert "may write, too" in vxs(*DRAW, "-o", "y.png", option, f"p/{name}", "--orbit", "--passes", "p", status=2).stderr
        assert (state(files / "p"), state(files)) == before
    (files / "p" / "depth.png").symlink_to("../x.png")
    assert "-o x.png and depth.png of --passes p are one file" in vxs(*DRAW, "-o", "x.png", "--passes", "p", status=2).stderr
    (files / "p" / "light.png").symlink_to("depth.png")
    assert "of it are one file: expected two" in vxs(*DRAW, "-o", "y.png", "--passes", "p", status=2).stderr
    (files / "p" / "light.png").unlink()
    vxs(*DRAW, "-o", "p/picture.png", "--passes", "p")  # depth.png leads to another file, which is none of this run's


@pytest.mark.parametrize("exists", [False, True])
def test_a_folder_is_no_output(vxs, files, exists):
    for line in ((*DRAW, "-o", "x.png", "--passes", "./x.png"), (*DRAW, "-o", "y.png", "--json", "x.png", "--orbit", "--passes", "x.png"),
                 ("bake", "level.gltf", *SMALL[:2], "-o", "x.png", "--resume", "x.png"),
                 ("bake", "level.gltf", *SMALL[:2], "-o", "z.vxs", "--json", "x.png", "--resume", "x.png")):
        if exists:
            (files / "x.png").mkdir(exist_ok=True)
        before = state(files)
        done = vxs(*line, status=2)
        assert one_error_line(done) and ("are one file: expected two names" in done.stderr or "is the extension of other files" in done.stderr)
        assert state(files) == before


def test_squares_are_neither_inputs_nor_outputs(vxs, files):
    bake = ("bake", "level.gltf", "--resolution", "64", "--quiet", "--resume", "q")
    vxs(*bake, "-o", "a.vxs")
    square, = (path.name for path in (files / "q").iterdir())
    kept = (files / "q" / square).read_bytes()
    for name in (square, "0" * 32 + ".square", ".vxs-1-1.tmp"):
        done = vxs(*bake, "-o", f"q/{name}", "--force", status=2)
        assert one_error_line(done) and f"-o q/{name}: is a file that --resume q may write, too" in done.stderr
    for name in ("0" * 32 + ".square", ".vxs-1-1.tmp"):
        for input in ("level.gltf", "level data.bin"):
            os.link(input, f"q/{name}")
            done = vxs(*bake, "-o", "b.vxs", status=2)
            assert one_error_line(done) and f"--resume q: {name} of it is the input itself, " in done.stderr
            (files / "q" / name).unlink()
    assert (files / "q" / square).read_bytes() == kept and not (files / "b.vxs").exists()


# --- what is replaced -----------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("command", COMMANDS)
def test_read_only_files(vxs, files, command):
    """As a version control system leaves them: 444."""
    (files / "old").write_text("old")
    (files / "old").chmod(0o444)
    before = state(files)
    line = arguments(command, {COMMANDS[command][2][0]: "old"})
    done = vxs(*line, status=4)
    assert one_error_line(done) and "old: cannot write: it is read-only: --force" in done.stderr and not done.stdout
    assert state(files) == before
    vxs(*line, "--force")
    assert (files / "old").read_bytes() != b"old" and (files / "old").stat().st_mode & 0o7777 == 0o444


def test_what_is_up_to_date_may_be_read_only(vxs, files):
    """bake --if-changed writes nothing then, and refuses what it would have to write before it looks at a triangle."""
    options = ("level.gltf", "-o", "level.vxs", "--report", "level.html", *SMALL)
    vxs("bake", *options)
    (files / "level.vxs").chmod(0o444)
    (files / "level.html").chmod(0o444)
    os.link(files / "level.vxs", files / "another name")
    before = state(files)
    assert "read-only" in vxs("bake", *options, status=4).stderr
    for command in ("bake", "plan"):
        assert vxs(command, *options, "--if-changed").stdout.startswith("up to date ")
        changed = vxs(command, *options, "--if-changed", "--region", "900,900,900,901,901,901", status=4)
        assert one_error_line(changed) and "level.vxs: cannot write: it is read-only: --force" in changed.stderr
    assert state(files) == before

    (files / "another name").unlink()
    (files / "level.vxs").chmod(0o644)
    page = vxs("bake", *options, "--if-changed", "--level", "1", status=4).stderr
    assert "level.html: cannot write: it is read-only: --force" in page and state(files)["level.html"] == before["level.html"]
    vxs("bake", *options, "--if-changed", "--level", "1", "--force")
    assert (files / "level.html").stat().st_mode & 0o7777 == 0o444 and state(files)["level.html"] != before["level.html"]


@pytest.mark.parametrize("mode", [0o600, 0o664, 0o640, 0o755, 0o2755, 0o4755, 0o4777, 0o6711, 0o1777])
def test_modes_are_kept(vxs, files, mode):
    """But for what was said of the old bytes: as whom they run."""
    (files / "a.vxs").write_bytes(b"old")
    (files / "a.vxs").chmod(mode)
    vxs("bake", "level.gltf", "-o", "a.vxs", *SMALL)
    assert (files / "a.vxs").stat().st_mode & 0o7777 == mode & 0o777 and (files / "a.vxs").read_bytes() != b"old"


def test_a_new_file_has_what_umask_leaves(vxs_path, files):
    subprocess.run([vxs_path, "bake", "level.gltf", "-o", "new", *SMALL], check=True, stdout=subprocess.DEVNULL, umask=0o027)
    assert (files / "new").stat().st_mode & 0o7777 == 0o640


@pytest.mark.skipif(os.geteuid() != 0, reason="only root may give files away")
def test_owner_and_group_are_kept(vxs, files):
    """In a folder that gives its own group to new files."""
    os.chown(files, 0, 1111)
    files.chmod(0o2755)
    os.chown("a.vxs", 1234, 1235)
    (files / "a.vxs").chmod(0o4640)
    vxs("bake", "level.gltf", "-o", "a.vxs", *SMALL)
    now = (files / "a.vxs").stat()
    assert (now.st_uid, now.st_gid, now.st_mode & 0o7777) == (1234, 1235, 0o640)


@pytest.mark.skipif(os.geteuid() != 0, reason="only root may become somebody else")
def test_an_owner_that_cannot_be_kept(vxs_path, made):
    """Somebody else's file, in a folder where everybody may write."""
    with tempfile.TemporaryDirectory() as name:
        folder = shutil.copytree(made, os.path.join(name, "files"))
        for path in (name, folder):
            os.chmod(path, 0o777)
        for path in os.listdir(folder):
            os.chmod(os.path.join(folder, path), 0o666)

        def run(*options):
            return subprocess.run([vxs_path, "bake", "level.gltf", "-o", "a.vxs", *SMALL, *options], cwd=folder, user=65534,
                                  group=65534, extra_groups=[], capture_output=True, text=True)

        try:
            done = run()
        except PermissionError:
            pytest.skip("nobody else may run the command where it lies")
        before = os.stat(os.path.join(folder, "a.vxs"))
        assert done.returncode == 4 and one_error_line(done) and "a.vxs: cannot write: its owner and group cannot be kept" in done.stderr
        assert before.st_uid == 0 and sorted(os.listdir(folder)) == sorted(os.listdir(made))
        done, now = run("--force"), os.stat(os.path.join(folder, "a.vxs"))
        assert done.returncode == 0 and "vxs: warning: " in done.stderr and "owner and group cannot be kept" in done.stderr
        assert now.st_uid == 65534 and now.st_ino != before.st_ino and now.st_mode & 0o777 == 0o666
        assert run().returncode == 0, "one's own"


def test_attributes_and_access_lists_are_kept(vxs, files):
    allowed = struct.pack("<I" + "HHI" * 5, 2, 1, 6, 2**32 - 1, 2, 4, 1000, 4, 4, 2**32 - 1, 16, 4, 2**32 - 1, 32, 0, 2**32 - 1)
    try:
        os.setxattr("a.vxs", "user.origin", b"build 7")
        os.setxattr("a.vxs", "system.posix_acl_access", allowed)
    except OSError as error:
        pytest.skip(f"this file system has none: {error}")
    before = (files / "a.vxs").stat()
    vxs("bake", "level.gltf", "-o", "a.vxs", *SMALL)
    now = (files / "a.vxs").stat()
    assert os.getxattr("a.vxs", "user.origin") == b"build 7" and os.getxattr("a.vxs", "system.posix_acl_access") == allowed
    assert now.st_ino != before.st_ino and now.st_mode == before.st_mode

    # what the folder gives to new files is not given to one that had none
    os.setxattr(files, "system.posix_acl_default", allowed)
    (files / "b.vxs").write_text("old")
    os.removexattr("b.vxs", "system.posix_acl_access")
    (files / "b.vxs").chmod(0o600)
    vxs("bake", "level.gltf", "-o", "b.vxs", *SMALL)
    assert os.listxattr("b.vxs") == [] and (files / "b.vxs").stat().st_mode & 0o7777 == 0o600


def test_hard_links(vxs, files):
    (files / "one").write_text("old")
    os.link("one", "two")
    before = state(files)
    done = vxs("bake", "level.gltf", "-o", "one", *SMALL, status=4)
    assert one_error_line(done) and "one: cannot write: it is one of 2 hard links to a file: --force" in done.stderr
    assert "2 hard links" in vxs("bake", "level.gltf", "-o", "one", *SMALL, "--force", "--strict", status=1).stderr
    assert state(files) == before and (files / "one").samefile("two")
    done = vxs("bake", "level.gltf", "-o", "one", *SMALL, "--force")
    assert done.stderr == "vxs: warning: one: was one of 2 hard links to a file: the others keep the old one\n"
    assert (files / "two").read_text() == "old" and vxs("validate", "one").stdout == "one: valid\n"


def test_links_to_nothing(vxs, files):
    (files / "dangling").symlink_to("nobody")
    (files / "loop").symlink_to("loop")
    (files / "round").symlink_to("round/a")
    before = {p.name for p in files.iterdir()}
    for name, says in (("dangling", "No such file"), ("loop", "Too many levels"), ("round/x", "Too many levels")):
        for options in (("-o", name), ("-o", "new", "--json", name)):
            done = vxs("bake", "level.gltf", *options, *SMALL, status=4)
            assert one_error_line(done) and f"{name}: cannot write: " in done.stderr and says in done.stderr
    assert {p.name for p in files.iterdir()} == before


def test_a_link_to_a_file_is_followed(vxs, files):
    (files / "d").mkdir()
    (files / "d" / "real").write_text("old")
    (files / "link").symlink_to("d/real")
    vxs("bake", "level.gltf", "-o", "link", *SMALL)
    assert (files / "link").is_symlink() and (files / "d" / "real").read_bytes() != b"old"
    (files / "d" / "real").chmod(0o444)
    assert "read-only" in vxs("bake", "level.gltf", "-o", "link", *SMALL, status=4).stderr


# --- devices, pipes, descriptors ------------------------------------------------------------------------------------------------------


def test_what_has_no_name_is_written_directly(vxs_path, files):
    """A pipe, a file by the number that it is open as, and one that has lost its name. What goes there is the asset alone."""
    asset = (files / "a.vxs").read_bytes()

    def run(output, **more):
        return subprocess.run([vxs_path, "bake", "level.gltf", "-o", output, *SMALL], check=True, stderr=subprocess.DEVNULL, **more)

    assert run("/dev/stdout", stdout=subprocess.PIPE).stdout == asset
    with tempfile.TemporaryFile() as file:
        run("/dev/stdout", stdout=file)
        assert os.pread(file.fileno(), 2 * len(asset), 0) == asset
    with open("one", "w") as one, open("two", "w") as two:
        run("/dev/stdout", stdout=one)
        run(f"/dev/fd/{two.fileno()}", pass_fds=[two.fileno()], stdout=subprocess.DEVNULL)
    assert (files / "one").read_bytes() == asset == (files / "two").read_bytes()
    os.mkfifo("pipe")
    with subprocess.Popen(["cat", "pipe"], stdout=subprocess.PIPE) as reader:
        run("pipe", stdout=subprocess.DEVNULL)
        assert reader.stdout.read() == asset
    assert stat.S_ISFIFO((files / "pipe").stat().st_mode)


# --- a power cut ----------------------------------------------------------------------------------------------------------------------


def test_bytes_are_on_the_disk_before_the_name(faulty, files):  # noqa: F811
    """The first fsync is the file's, before it is renamed; the second the folder's, after. One that fails is an error."""
    bake, new = ("bake", "level.gltf", "-o", "old", *SMALL), (files / "a.vxs").read_bytes()
    (files / "old").write_text("old")
    assert faulty.calls("fsync", *bake) == 2
    for n, left in ((1, b"old"), (2, new)):
        (files / "old").write_text("old")
        before = {p.name for p in files.iterdir()}
        done = faulty(f"fsync:{n}:{errno.EIO}", *bake)
        assert done.returncode == 4 and one_error_line(done) and b"old: cannot write: Input/output error" in done.stderr
        assert (files / "old").read_bytes() == left and {p.name for p in files.iterdir()} == before
    assert faulty(f"fsync:1:{errno.EINVAL}", *bake, FAULT_EVERY="1").returncode == 0, "a file system that knows no fsync"
