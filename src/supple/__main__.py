"""`python -m supple`: the command line for processes started by module, such as those of MPI."""

from supple.cli.main import main

if __name__ == "__main__":
    main()
