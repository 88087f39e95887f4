"""Run the command line as `python -m mecanique`."""

from mecanique.cli import main

if __name__ == "__main__":
    main()
