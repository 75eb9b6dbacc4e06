"""``python -m kinopix``: the command."""

from kinopix.own_packages import claim_packages

claim_packages()

from instrument.cli import main  # noqa: E402 - the name instrument must be claimed before

if __name__ == "__main__":
    main()
