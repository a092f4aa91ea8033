"""Runs commands and servers in a minimal Debian in a folder, and connects two of them by network namespaces."""
import contextlib
import os
import pathlib
import re
import resource
import subprocess

ROOT = pathlib.Path(__file__).resolve().parents[2]
BIN = pathlib.Path(os.environ.get("PALPATE_BIN", ROOT / "build/release/bin"))
BARE = {"PATH": "/usr/sbin:/usr/bin:/sbin:/bin", "HOME": "/root", "LC_ALL": "C.UTF-8", "DEBIAN_FRONTEND": "noninteractive"}
PATIENCE = 600


def must(*command, **options):
    """Runs a command to its end and returns its output. Raises AssertionError with the output if it fails."""
    done = subprocess.run([str(word) for word in command], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          text=True, timeout=PATIENCE, **options)
    if done.returncode != options.get("code", 0):
        raise AssertionError(f"{' '.join(map(str, command))}: exit {done.returncode}\n{done.stdout[-4000:]}")
    return done.stdout


def processor_seconds():
    """Returns the processor time of the children that have ended [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


class BareDebian:
    """A minimal Debian, made by tests/bare_root.sh in `folder`. It exists within the `with` block."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)

    def __enter__(self):
        # The folder is in memory, because dpkg waits for the disk after each file.
        self.folder.parent.mkdir()
        must("mount", "-t", "tmpfs", "-o", "size=4G", "tmpfs", self.folder.parent)
        must(ROOT / "tests/bare_root.sh", self.folder, "true", env=os.environ | {"CACHE": str(BIN.parent / "debootstrap")})
        must("rm", "-rf", self.folder / "palpate")  # removes the sources, so that only the packages' files exist
        must("mount", "-t", "proc", "proc", self.folder / "proc")
        must("mount", "--bind", "/dev", self.folder / "dev")
        return self

    def __exit__(self, *error):
        for folder in (self.folder / "proc", self.folder / "dev", self.folder.parent):
            subprocess.run(["umount", "-l", str(folder)], check=False)

    def command(self, *words, user="root", net=None, read_only=False):
        inside = ["ip", "netns", "exec", net] if net else []
        if read_only:  # except /tmp, as in a container
            mounts = "mount --bind $0 $0 && mount -o remount,bind,ro $0 && mount -t tmpfs tmpfs $0/tmp"
            inside += ["unshare", "--mount", "sh", "-c", f'{mounts} && exec "$@"', str(self.folder)]
        return [*inside, "chroot", f"--userspec={user}", str(self.folder), *map(str, words)]

    def run(self, *words, env=None, **where):
        """Runs a command. Returns exit code and output."""
        done = subprocess.run(self.command(*words, **where), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True, timeout=PATIENCE, env=BARE | (env or {}), check=False)
        return done.returncode, done.stdout

    def must(self, *words, **options):
        code, output = self.run(*words, **options)
        if code != 0:
            raise AssertionError(f"{' '.join(map(str, words))}: exit {code}\n{output[-4000:]}")
        return output

    @contextlib.contextmanager
    def serving(self, *words, env=None, **where):
        """Starts a slave. Yields the address that it prints, and requires a clean end on SIGTERM."""
        with subprocess.Popen(self.command(*words, **where), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, text=True, env=BARE | (env or {})) as process:
            try:
                line = process.stdout.readline()
                match = re.fullmatch(r"listening on (\S+)\n", line)
                if not match:
                    process.kill()
                    raise AssertionError(f"{words}: {line!r} {process.stderr.read()}")
                yield match.group(1)
            finally:
                process.terminate()
                process.communicate(timeout=60)
        if process.returncode != 0:
            raise AssertionError(f"{words}: exit {process.returncode} after SIGTERM")

    @contextlib.contextmanager
    def started(self, *words, env=None, **where):
        """Starts a program that runs until the end of the `with` block. Yields its process."""
        with subprocess.Popen(self.command(*words, **where), stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL, env=BARE | (env or {})) as process:
            try:
                yield process
            finally:
                process.terminate()

    def palpate_files(self):
        """Returns the files of Palpate, without those in dpkg's database."""
        others = [self.folder / name for name in ("root", "srv", "tmp", "dev", "proc", "var/lib/dpkg", "var/log")]
        prune = " -o ".join(f"-path {name}" for name in others).split()
        found = must("find", self.folder, "(", *prune, ")", "-prune", "-o", "-ipath", f"{self.folder}*palpate*", "-print")
        return sorted("/" + os.path.relpath(line, self.folder) for line in found.splitlines())


@contextlib.contextmanager
def two_networks():
    """Makes two network namespaces with a veth pair between them. Yields their names and their addresses 10.77.0.1 and
    10.77.0.2."""
    slave, master = f"palpate-ps-{os.getpid()}", f"palpate-pm-{os.getpid()}"
    try:
        for name in (slave, master):
            must("ip", "netns", "add", name)
            must("ip", "-n", name, "link", "set", "lo", "up")
        must("ip", "link", "add", "palpate-p", "netns", slave, "type", "veth", "peer", "name", "palpate-q", "netns", master)
        for name, device, address in ((slave, "palpate-p", "10.77.0.1/24"), (master, "palpate-q", "10.77.0.2/24")):
            must("ip", "-n", name, "address", "add", address, "dev", device)
            must("ip", "-n", name, "link", "set", device, "up")
        yield slave, master
    finally:
        for name in (slave, master):
            subprocess.run(["ip", "netns", "delete", name], check=False)
