"""Shared by all tests: compiled programs are kept between tests, workers and runs."""

from pathlib import Path

from supple.cli.compilation_cache import keep_compiled_programs

keep_compiled_programs(Path(__file__).parents[1] / ".pytest_cache" / "compiled")
