"""Command line: `tautflex COMMAND`; heavy libraries load inside the commands, so start-up is fast."""

from __future__ import annotations

import io
import os
import sys
from collections.abc import Sequence

from cyclopts import App, CycloptsError, Parameter, UnknownCommandError, UnusedCliTokensError

from tautflex import compiling
from tautflex._version import __version__
from tautflex.cli.cases.check import check
from tautflex.cli.cases.init import init
from tautflex.cli.cases.keys import keys
from tautflex.cli.cases.modes import modes
from tautflex.cli.cases.tune import tune
from tautflex.cli.late import import_late
from tautflex.cli.loops.authority import authority
from tautflex.cli.loops.control import control
from tautflex.cli.loops.evaluate import evaluate
from tautflex.cli.loops.train import train
from tautflex.cli.runs.animate import animate
from tautflex.cli.runs.explore import explore
from tautflex.cli.runs.export import export
from tautflex.cli.runs.report import report
from tautflex.cli.runs.reproduce import reproduce
from tautflex.cli.runs.run import run
from tautflex.cli.studies.design import design
from tautflex.cli.studies.sweep import sweep
from tautflex.compilers import helped
from tautflex.errors import InputError, MissingExtraError, NotWrittenError, TautflexError
from tautflex.interrupts import exit_code, listening

DONE, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130

app = App(
    name="tautflex",
    help="Nonlinear dynamics of tensioned membrane antennas on maneuvering spacecraft.",
    version=__version__,
    help_format="plaintext",
    default_parameter=Parameter(show_default=False, negative=""),
    print_error=False,
    exit_on_error=False,
    suppress_keyboard_interrupt=False,
    result_action="return_value",
)
for one in (
    init,
    check,
    keys,
    modes,
    tune,
    run,
    control,
    authority,
    train,
    evaluate,
    sweep,
    design,
    animate,
    report,
    explore,
    reproduce,
    export,
):
    app.command(one)
app.register_install_completion_command(add_to_startup=False)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code: 0 done, 1 not converged, 2 bad input."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="surrogateescape")  # names of files may be in any encoding
    compiling.announcing = True
    # XLA logs as an error that it compiles for more than two minutes. What really fails there raises an exception, and
    # what ends the process is logged at any level; whoever sets the variable sees all.
    os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")
    import_late("xarray")  # with pandas a fifth of the time that `tautflex check` takes
    with listening():
        code = _outcome(sys.argv[1:] if arguments is None else list(arguments))
        return exit_code() or code


def _outcome(arguments: list[str]) -> int:
    if arguments[:1] == ["help"]:
        arguments = [*arguments[1:], "--help"]
    try:
        with helped():
            outcome = app(arguments)
    except CycloptsError as error:
        return _report(_usage(error, arguments), BAD_INPUT)
    except NotWrittenError as error:
        return _report(str(error), FAILED)
    except InputError as error:
        return max(_report(problem, BAD_INPUT) for problem in error.problems)
    except MissingExtraError as error:
        return _report(str(error), BAD_INPUT)
    except TautflexError as error:
        return _report(str(error), FAILED)
    except BrokenPipeError:
        # The reader of our output left, as `| head` does; there is nobody to tell.
        sys.stdout = None  # keeps the interpreter from flushing into the closed pipe
        return FAILED
    except OSError as error:
        place = f"{error.filename}: " if error.filename else ""
        reason = error.strerror or str(error)
        return _report(f"{place}cannot write or read ({reason}); choose another place or free some space", FAILED)
    except KeyboardInterrupt:
        return _report("interrupted", INTERRUPTED)
    except Exception as error:
        if exit_code():  # what compiled code makes of an interrupt
            return _report("interrupted", INTERRUPTED)
        blamed = _blame(error)
        if blamed is None:
            raise
        return _report(blamed, BAD_INPUT)
    return outcome if isinstance(outcome, int) else DONE


def _usage(error: CycloptsError, arguments: list[str]) -> str:
    """One line about arguments that make no command."""
    first = next(iter(arguments), "")
    known = f"{first} " if first in app else ""
    text = " ".join(str(error).split())
    if isinstance(error, UnusedCliTokensError):
        text = f"expected no more arguments, got {' '.join(map(repr, error.unused_tokens or ()))}."
    elif isinstance(error, UnknownCommandError) and first.startswith("-"):
        text = f"{first}: expected a command before its options, as in `tautflex check m2.toml --json`."
    return f"{text} Try `tautflex {known}--help`."


def _blame(error: Exception) -> str | None:
    """One line about a plugin whose class misbehaved; None where there is none to blame."""
    plugins = sys.modules.get("tautflex.case.plugins")
    return None if plugins is None else plugins.blame(error)


def _report(text: str, code: int) -> int:
    from tautflex.case.messages import one_line

    print(f"tautflex: error: {one_line(text)}", file=sys.stderr)  # noqa: T201 - the command line's one error line
    return code
