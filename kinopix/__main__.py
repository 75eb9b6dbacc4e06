"""``python -m kinopix``: the command."""

import gc

from kinopix.beginning import end_in_one_line

end_in_one_line()
# What is imported is no garbage: to look through it again and again takes a tenth of a command's time.
gc.set_threshold(20_000, 20, 20)

from kinopix.own_packages import claim_packages  # noqa: E402 - what is loaded from here on may take long

claim_packages()

from instrument.cli import main  # noqa: E402 - the name instrument must be claimed before

if __name__ == "__main__":
    main()
