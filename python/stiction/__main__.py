"""Makes ``python -m stiction`` the command ``runner``."""

from stiction._command import main

if __name__ == "__main__":
    main()
