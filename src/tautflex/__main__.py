"""The command `tautflex`, and `python -m tautflex`."""

import signal

# While libraries load, Ctrl-C ends the process as SIGTERM does, without a traceback; then commands listen to both.
if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
    signal.signal(signal.SIGINT, signal.SIG_DFL)

from tautflex.cli import main

if __name__ == "__main__":
    code = main()
    # Where Ctrl-C met code that was compiled from a text, Python ends as if nobody had caught it, until more is run.
    exec("")
    raise SystemExit(code)
