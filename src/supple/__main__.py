"""`python -m supple`: the command line, where a process is started by its module, as MPI does."""

from supple.cli.main import main

if __name__ == "__main__":
    main()
