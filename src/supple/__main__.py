"""Run the command line as `python -m supple`, for example in MPI processes."""

from supple.cli.main import main

if __name__ == "__main__":
    main()
