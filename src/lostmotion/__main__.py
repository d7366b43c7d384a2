"""`python -m lostmotion` is the command line."""

from lostmotion.cli import main

if __name__ == "__main__":
    main()
