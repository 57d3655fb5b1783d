"""A real Slurm of one node, for tests: munged, slurmctld and slurmd as children of this process, on the loopback interface, with all their files in one folder. Needs root."""

from __future__ import annotations

import os
import re
import shutil
import socket
import subprocess
import time
from pathlib import Path

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "scancel", "sinfo", "scontrol")
PATH = f"{os.environ.get('PATH', '')}:/usr/sbin:/sbin"

CONF = """
ClusterName=one
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={port}
SlurmdPort={next_port}
# Bound to the address above, and to no other interface.
CommunicationParameters=NoCtldInAddrAny,NoInAddrAny
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
MailProg=/bin/true
# A plain container has no cgroups: processes of a job are found by their parents.
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
# A node that was down is used again when its slurmd is back.
ReturnToService=2
# Short, so that a fault is seen within seconds.
InactiveLimit=10
KillWait=2
SlurmdTimeout=10
SlurmctldTimeout=10
NodeName={host} NodeAddr=127.0.0.1 CPUs={cpus} RealMemory={memory} State=UNKNOWN
PartitionName=one Nodes={host} Default=YES MaxTime=INFINITE State=UP
"""


def why_not() -> str | None:
    """What keeps a Slurm from running here, as a sentence; None for nothing."""
    if missing := [program for program in PROGRAMS if shutil.which(program, path=PATH) is None]:
        return f"Slurm is not installed ({', '.join(missing)}): apt-get install slurm-wlm munge"
    return None if os.getuid() == 0 else "a Slurm of its own needs root"


class OneNodeSlurm:
    """Starts at once. folder: a short path, for unix sockets are in it."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.host = folder, socket.gethostname().partition(".")[0]
        self.environment = os.environ | {"SLURM_CONF": str(folder / "slurm.conf"), "PATH": PATH}
        self._daemons: list[subprocess.Popen] = []
        self._configure()
        try:
            self._start("munged", "--foreground", "--force", *(f"--{key}={folder}/{name}" for key, name in MUNGE.items()))
            self._wait(lambda: (folder / "munge.socket").exists(), "munged did not begin")
            self._start("slurmctld", "-D", "-c", "-f", str(folder / "slurm.conf"))
            self._start("slurmd", "-D", "-f", str(folder / "slurm.conf"))
            self._wait(lambda: self.node_state() == "idle", "the node was not idle")
        except BaseException:
            self.stop()
            raise

    def call(self, *command: str) -> str:
        """What a program of Slurm prints."""
        return subprocess.run(command, env=self.environment, capture_output=True, text=True, check=True, timeout=30).stdout

    def node_state(self) -> str:
        return subprocess.run(["sinfo", "-h", "-o", "%T"], env=self.environment, capture_output=True, text=True, check=False).stdout.strip()

    def jobs(self, state: str | None = None) -> list[str]:
        """The numbers of the jobs in the queue."""
        return self.call("squeue", "-h", "-o", "%A", *(() if state is None else ("-t", state))).split()

    def stop(self) -> None:
        """Cancel the jobs, whose processes outlive the daemons, then end these, the last first."""
        try:
            if jobs := self.jobs():
                self.call("scancel", *jobs)
                self._wait(lambda: not self.jobs(), "jobs did not end")
        except (subprocess.SubprocessError, AssertionError):
            pass
        for daemon in reversed(self._daemons):
            daemon.terminate()
            try:
                daemon.wait(5)
            except subprocess.TimeoutExpired:
                daemon.kill()
                daemon.wait()

    def _configure(self) -> None:
        folder = self.folder
        for name in ("state", "spool"):
            (folder / name).mkdir(parents=True)
        (folder / "munge.key").touch(mode=0o600)
        (folder / "munge.key").write_bytes(os.urandom(1024))
        memory = int(re.search(r"MemTotal:\s+(\d+)", Path("/proc/meminfo").read_text())[1]) // 1024
        port = _two_free_ports()
        text = CONF.format(folder=folder, host=self.host, port=port, next_port=port + 1, cpus=os.cpu_count(), memory=memory)
        (folder / "slurm.conf").write_text(text)
        # slurmd loads a plugin of cgroups whatever is set above: a new one can be told none, and version 1 of an old one does nothing unless it is used.
        version = subprocess.run(["slurmd", "-V"], env=self.environment, capture_output=True, text=True, check=True).stdout
        (folder / "cgroup.conf").write_text(f"CgroupPlugin={'cgroup/v1' if re.search(r' 2[0-3][.]', version) else 'disabled'}\n")

    def _start(self, program: str, *arguments: str) -> None:
        with open(self.folder / f"{program}.out", "wb") as out:
            command = [shutil.which(program, path=PATH), *arguments]
            # A session of its own: a Ctrl-C at the terminal of the tests does not reach it.
            self._daemons.append(subprocess.Popen(command, env=self.environment, stdin=subprocess.DEVNULL, stdout=out, stderr=out, start_new_session=True))

    def _wait(self, until, otherwise: str, seconds: float = 30) -> None:
        end = time.monotonic() + seconds
        while not until():
            assert time.monotonic() < end, f"{otherwise} within {seconds} s: {self._said()}"
            time.sleep(0.1)

    def _said(self) -> str:
        return "\n".join(f"{path.name}: {path.read_text(errors='replace')[-1000:]}" for path in (*self.folder.glob("*.out"), *self.folder.glob("*.log")))


MUNGE = {"key-file": "munge.key", "socket": "munge.socket", "pid-file": "munged.pid", "seed-file": "munge.seed", "log-file": "munged.log"}


def _two_free_ports() -> int:
    for _ in range(100):
        with socket.socket() as one, socket.socket() as two:
            one.bind(("127.0.0.1", 0))
            port = one.getsockname()[1]
            try:
                two.bind(("127.0.0.1", port + 1))
            except OSError:
                continue
            return port
    raise OSError("no two neighbouring ports are free")
