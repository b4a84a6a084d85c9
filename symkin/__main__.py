"""The command `symkin`, also as `python -m symkin`."""

import os
import signal


def main() -> None:
    """Run the command. Ctrl-C while its modules are being loaded, when nothing is written yet, ends
    the process with the sentence that later ones have.
    """
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _leave)
    from symkin.cli.app import main as run

    run()


def _leave(*_: object) -> None:
    os.write(2, b"symkin: interrupted\n")
    os._exit(128 + signal.SIGINT)


if __name__ == "__main__":
    main()
