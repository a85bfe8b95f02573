"""A Slurm of one machine, for tests: controller, one node, accounting. All on loopback.

Settings, keys, ports and data are in a folder of their own, which is removed in the end. Only
/etc/slurm/slurm.conf is a link to it meanwhile: the plugin lets no job keep SLURM_CONF. A machine
that has this file already is left alone. It needs root and Debian's packages.
"""

import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from campaigns import ROOT
from command_line import outcome
from reproduce import GUARD, Surroundings

PACKAGES = ("slurm-wlm", "slurm-client", "slurmdbd", "munge", "mariadb-server")
PROGRAMS = ("slurmctld", "slurmd", "slurmdbd", "munged", "mariadbd", "sbatch", "sacct")
PLUGINS = ("snakemake-executor-plugin-slurm", "snakemake-executor-plugin-slurm-jobstep")
PROFILE = ("--workflow-profile", "profiles/slurm")
SYSTEM_SETTINGS = Path("/etc/slurm/slurm.conf")
PATH = os.pathsep.join([os.environ["PATH"], "/usr/sbin", "/sbin"])
_TEMPLATE = Path(__file__).with_name("slurm.conf")


class UnavailableError(Exception):
    """Why there can be no Slurm here, in a sentence."""


def install() -> None:
    """Install Debian's packages where they are missing.

    Raises:
        UnavailableError: Not root, no apt-get, or apt-get fails.
    """
    if os.geteuid() != 0:
        raise UnavailableError("the daemons of Slurm are started by root only")
    if not all(shutil.which(program, path=PATH) for program in PROGRAMS):
        get = "apt-get update -qq && apt-get install -qq --no-install-recommends"
        quiet = {**os.environ, "DEBIAN_FRONTEND": "noninteractive"}
        code, text = outcome(["sh", "-c", f"{get} {' '.join(PACKAGES)}"], env=quiet)
        if code != 0:
            raise UnavailableError(f"Slurm could not be installed: {text.strip()[-300:]}")


def install_plugin(folder: Path) -> None:
    """Install the locked plugin apart from the tests' environment, which it would slow down.

    Raises:
        UnavailableError: The package index cannot be reached.
    """
    lock = (ROOT / "requirements/slurm.lock").read_text(encoding="utf-8")
    pins = re.findall(r"(?m)^[a-z].*\n(?: .*\n)*", lock)
    wanted = [pin for pin in pins if pin.partition("==")[0] in (*PLUGINS, "throttler")]
    (folder / "plugin.lock").write_text("".join(wanted), encoding="utf-8")
    pip = [sys.executable, "-m", "uv", "pip", "install", "--quiet", "--no-deps"]
    pip += ["--python", sys.executable, "--require-hashes", "--target", str(folder)]
    code, text = outcome([*pip, "--requirement", str(folder / "plugin.lock")])
    if code != 0:
        raise UnavailableError(f"the plugin could not be installed: {text.strip()[-300:]}")


class Cluster:
    """A running Slurm; `environment` is that of its commands and jobs."""

    def __init__(self, folder: Path, cores: int) -> None:
        self.cores = cores
        self.folder = folder
        self.host = socket.gethostname().split(".")[0]
        with ExitStack() as stack:
            sockets = [
                stack.enter_context(socket.create_server(("127.0.0.1", 0))) for _ in range(4)
            ]
            self.ports = [free_socket.getsockname()[1] for free_socket in sockets]
        self.environment = {"SLURM_CONF": str(folder / "slurm.conf"), "PATH": PATH}
        self._daemons: dict[str, subprocess.Popen[bytes]] = {}

    def around(self, project: Path, plugin: Path) -> Surroundings:
        """What Snakemake finds around it that submits a project's jobs here."""
        path = os.pathsep.join(map(str, (project / "workflow", GUARD, plugin)))
        return Surroundings("2", {**self.environment, "PYTHONPATH": path})

    def command(self, *words: str) -> str:
        """What a command of Slurm prints."""
        env = {**os.environ, **self.environment}
        return subprocess.run(words, env=env, capture_output=True, text=True, check=True).stdout

    def up(self) -> None:
        """Start everything and wait until the node takes jobs."""
        for name in ("state", "spool", "database"):
            (self.folder / name).mkdir()
        self._write_settings()
        self._start_munge()
        self._start_database()
        self._start("slurmdbd", "-D")
        self._wait(
            lambda: self.command("sacctmgr", "-n", "show", "cluster") is not None, "slurmdbd"
        )
        for words in ("cluster test", "account lab cluster=test", "user root account=lab"):
            self.command("sacctmgr", "-i", "add", *words.split())
        self._start("slurmctld", "-D")
        self.start_node()
        self._wait(lambda: "idle" in self.command("sinfo", "-h", "-o", "%t"), "the node")

    def down(self) -> None:
        """End every job and every daemon."""
        if "slurmctld" in self._daemons:
            with suppress(OSError, subprocess.CalledProcessError):
                self.command("scancel", "--user", "root")
            with suppress(OSError, subprocess.CalledProcessError):
                self._wait(lambda: not self.command("squeue", "-h"), "the end of all jobs")
        for daemon in reversed(self._daemons.values()):
            daemon.terminate()
        for daemon in self._daemons.values():
            try:
                daemon.wait(20)
            except subprocess.TimeoutExpired:
                daemon.kill()

    def start_node(self) -> None:
        """Start slurmd; jobs that ran on go on."""
        self._start("slurmd", "-D")

    def stop_node(self) -> None:
        """Kill slurmd; what it has started goes on by itself."""
        self._daemons["slurmd"].send_signal(signal.SIGKILL)
        self._daemons.pop("slurmd").wait()

    def jobs(self) -> list[tuple[str, str]]:
        """Comment and state of every job that ever was; one entry per start of a requeued one."""
        table = self.command("sacct", "-X", "-n", "-P", "-D", "-o", "Comment,State")
        pairs = (line.partition("|") for line in table.splitlines())
        return [(comment, state) for comment, _, state in pairs]

    def _start(self, program: str, *arguments: str) -> None:
        with (self.folder / f"{program}.out").open("ab") as output:
            self._daemons[program] = subprocess.Popen(
                [program, *arguments],
                env={**os.environ, **self.environment},
                stdout=output,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )

    def _wait(self, ready: Callable[[], object], what: str, seconds: float = 60) -> None:
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            with suppress(OSError, subprocess.CalledProcessError):
                if ready():
                    return
            time.sleep(0.2)
        logs = "\n".join(
            f"{log.name}: {log.read_text(errors='replace')[-400:]}"
            for log in sorted(self.folder.glob("*.out"))
        )
        raise UnavailableError(f"{what} did not come up within {seconds:.0f} s\n{logs}")

    def _start_munge(self) -> None:
        """Start munged with a key and a socket of its own."""
        key = self.folder / "munge.key"
        key.write_bytes(os.urandom(128))
        key.chmod(0o400)
        files = [f"--key-file={key}", f"--seed-file={self.folder}/munge.seed"]
        files += [f"--log-file={self.folder}/munged.log", f"--pid-file={self.folder}/munged.pid"]
        self._start("munged", "--foreground", f"--socket={self.folder}/munge.socket", *files)

    def _start_database(self) -> None:
        data = self.folder / "database"
        options = ["--no-defaults", "--user=root", f"--datadir={data}", "--skip-test-db"]
        self.command("mariadb-install-db", *options, "--auth-root-authentication-method=normal")
        socket_file = self.folder / "database.socket"
        where = ["--bind-address=127.0.0.1", f"--port={self.ports[3]}", f"--socket={socket_file}"]
        small = ["--innodb-buffer-pool-size=64M", "--skip-name-resolve"]
        self._start("mariadbd", "--no-defaults", "--user=root", f"--datadir={data}", *where, *small)
        client = ["mariadb", "--no-defaults", f"--socket={socket_file}", "-e"]
        self._wait(lambda: self.command(*client, "SELECT 1"), "MariaDB")
        self.command(*client, "CREATE USER 'slurm'@'127.0.0.1' IDENTIFIED BY 'test'")
        self.command(*client, "GRANT ALL ON slurm_acct_db.* TO 'slurm'@'127.0.0.1'")

    def _write_settings(self) -> None:
        controller, node, accounting, database = self.ports
        shared = (
            f"AuthType=auth/munge\nAuthInfo=socket={self.folder}/munge.socket\nSlurmUser=root\n"
        )
        dbd = self.folder / "slurmdbd.conf"
        dbd.write_text(
            f"{shared}DbdHost=localhost\nDbdAddr=127.0.0.1\nDbdPort={accounting}\n"
            f"PidFile={self.folder}/slurmdbd.pid\nLogFile={self.folder}/slurmdbd.log\n"
            f"StorageType=accounting_storage/mysql\nStorageHost=127.0.0.1\n"
            f"StoragePort={database}\nStorageUser=slurm\nStoragePass=test\n"
        )
        dbd.chmod(0o600)  # slurmdbd refuses others
        settings = _TEMPLATE.read_text(encoding="utf-8").format(
            **{"shared": shared, "host": self.host, "folder": self.folder, "cpus": self.cores},
            **{"controller": controller, "node": node, "accounting": accounting},
            memory=os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") // 2**20 * 8 // 10,
        )
        (self.folder / "slurm.conf").write_text(settings)
        SYSTEM_SETTINGS.parent.mkdir(exist_ok=True)
        SYSTEM_SETTINGS.symlink_to(self.folder / "slurm.conf")


@contextmanager
def running_cluster(cores: int) -> Iterator[Cluster]:
    """A Slurm that runs jobs on so many cores, while the block runs.

    Raises:
        UnavailableError: Slurm cannot be installed or started here.
    """
    install()
    if SYSTEM_SETTINGS.is_symlink() or SYSTEM_SETTINGS.exists():
        raise UnavailableError(f"this machine has a Slurm of its own: {SYSTEM_SETTINGS}")
    # a socket's path has at most 107 characters, hence not below pytest's folder
    with tempfile.TemporaryDirectory(prefix="oilfilm-slurm-") as folder:
        Path(folder).chmod(0o755)  # munged insists
        cluster = Cluster(Path(folder), cores)
        try:
            cluster.up()
            yield cluster
        finally:
            cluster.down()
            SYSTEM_SETTINGS.unlink(missing_ok=True)
