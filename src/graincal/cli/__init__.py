"""The command line: one command a file. A command imports what it needs when it runs, so that `graincal --help` answers at once."""

from __future__ import annotations

import signal
import sys
from types import FrameType
from typing import Any

import typer

from graincal.cli.advise import advise
from graincal.cli.ask import ask
from graincal.cli.calibrate import calibrate
from graincal.cli.check import check
from graincal.cli.compare import compare
from graincal.cli.completion import completion, ready_to_complete
from graincal.cli.demo import demo
from graincal.cli.explore import explore
from graincal.cli.export import export
from graincal.cli.import_runs import import_runs
from graincal.cli.init import init
from graincal.cli.pack import pack
from graincal.cli.predict import predict
from graincal.cli.report import report
from graincal.cli.reproduce import reproduce
from graincal.cli.resume import resume
from graincal.cli.saying import say
from graincal.cli.schema import schema
from graincal.cli.simulate import simulate
from graincal.cli.status import status
from graincal.cli.tell import tell
from graincal.cli.version import print_version
from graincal.cli.watch import watch
from graincal.data import InputError
from graincal.execution.interrupts import ENDING

app = typer.Typer(name="graincal", no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False)
app.command(epilog="Example:  graincal demo -o graincal-demo")(demo)
app.command(epilog="Example:  graincal init lab.csv --strain engineering --confining-pressure 5e5 --packing packing.csv")(init)
app.command(epilog="Example:  graincal check calibration.toml --plot references.png")(check)
app.command(epilog="Example:  graincal calibrate calibration.toml -o campaign")(calibrate)
app.command(epilog="Example:  graincal explore calibration.toml --to 0.25 --runs 500 -o library")(explore)
app.command(epilog="Example:  graincal resume campaign --max-evaluations 200")(resume)
app.command(epilog="Example:  graincal ask campaign > samples.csv")(ask)
app.command(epilog="Example:  graincal tell campaign runs")(tell)
app.command(epilog="Example:  graincal status campaign --json")(status)
app.command(epilog="Example:  graincal watch campaign")(watch)
app.command(epilog="Example:  graincal report campaign --figures png --figures pdf")(report)
app.command(epilog="Example:  graincal predict campaign --confining-pressure 1e6 --against other.csv --plot prediction.png")(predict)
app.command(epilog="Example:  graincal compare linear hertz --against other.csv --confining-pressure 1e6")(compare)
app.command(epilog='Example:  graincal advise campaign --test undrained --test "triaxial 1e6"')(advise)
app.command(epilog="Example:  graincal export campaign --to csv")(export)
app.command(epilog="Example:  graincal reproduce hartmann2022 --study proof --data DATA -o studies")(reproduce)
app.command(epilog="Example:  graincal completion bash > graincal.bash")(completion)
app.command(epilog="Example:  graincal schema > calibration.schema.json")(schema)
app.command(epilog="Example:  graincal pack --particles 2000 --void-ratio 0.68 --grading toyoura --seed 1 -o packing.csv")(pack)
app.add_typer(import_runs, name="import")
app.add_typer(simulate, name="simulate")


@app.callback()
def _root(
    version: bool = typer.Option(False, "--version", callback=print_version, is_eager=True, help="Print version, commit, compiler and instruction set."),
) -> None:
    """Calibrate DEM contact parameters against laboratory tests."""


def main(arguments: list[str] | None = None) -> None:
    """Run a command and exit: 0 if all is well, 1 for a mistake or trouble (a sentence on standard error), 2 for a wrong call, 128 and the signal's number after Ctrl-C (130), SIGTERM (143) or SIGHUP (129)."""
    heard: list[int] = []
    before = _hear(heard)
    for stream in (sys.stdout, sys.stderr):
        # A terminal without Greek letters shows a question mark, not a traceback.
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")
    ready_to_complete()
    try:
        app(arguments)
    except SystemExit as ended:
        if heard and ended.code:
            sys.exit(128 + heard[0])
        raise
    except InputError as error:
        say(error, err=True)
        sys.exit(1)
    except OSError as error:
        # The terminal may be gone, where that was the signal.
        if heard:
            sys.exit(128 + heard[0])
        # Of a file that nobody looked at before: whatever the system says of it.
        say(InputError(f"{error.filename or 'a file'}: this cannot be read or written ({error.strerror or error})."), err=True)
        sys.exit(1)
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _hear(heard: list[int]) -> dict[signal.Signals, Any]:
    """Have the first signal to end, which is noted, end what is under way in good order; the same signal once more kills. Returns the handlers that were there."""

    def interrupt_once(number: int, frame: FrameType | None) -> None:
        signal.signal(number, signal.SIG_DFL)
        heard.append(number)
        raise KeyboardInterrupt("" if number == signal.SIGINT else f"ended by {signal.Signals(number).name}")

    before: dict[signal.Signals, Any] = {}
    for number in ENDING:
        # What is begun by nohup is to hear no SIGHUP.
        if number == signal.SIGINT or signal.getsignal(number) is not signal.SIG_IGN:
            before[number] = signal.signal(number, interrupt_once)
    return before
