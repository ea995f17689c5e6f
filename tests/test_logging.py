"""Library code logs to "supple" and prints nothing; what commands print are records as well."""

import logging
import time

import pytest
from typer.testing import CliRunner

import supple as sp
from supple.cli.main import app
from supple.errors import ModelError
from supple.progress import with_progress_bar
from supple.terminal import reported_errors, say


@with_progress_bar("counting")
def count(*, fails=False):
    time.sleep(0.01)
    if fails:
        raise ModelError("no more numbers: count less")


def test_long_work_logs_what_it_took(caplog, capsys):
    with caplog.at_level(logging.INFO, logger="supple"):
        count()
    ((name, level, message),) = caplog.record_tuples
    assert (name, level) == ("supple", logging.INFO)
    title, seconds = message.removesuffix(" s").split(": ")
    assert title == "counting"
    assert 0.01 <= float(seconds) < 1
    assert capsys.readouterr() == ("", "")


def test_work_that_fails_raises_and_logs_nothing(caplog):
    with caplog.at_level(logging.INFO, logger="supple"), pytest.raises(ModelError):
        count(fails=True)
    assert not caplog.records


def test_every_long_function_does(caplog):
    with caplog.at_level(logging.INFO, logger="supple"):
        system = sp.System([sp.RigidBody("ball", 1.0, (0, 0, 0), ((1, 0, 0), (0, 1, 0), (0, 0, 1)))])
        sp.simulate(system, sp.Run(0.1, 0.1))
    assert [record.message.split(":")[0] for record in caplog.records] == ["simulating"]


def test_a_table_of_a_command_is_a_record(caplog, tmp_path):
    """The same text on the terminal and in a log file."""
    path = tmp_path / "strip.inp"
    path.write_text("*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n*ELEMENT, TYPE=S3, ELSET=all\n1, 1, 2, 3\n")
    done = CliRunner().invoke(app, ["info", str(path)])
    assert done.exit_code == 0, done.output
    assert caplog.records
    assert {record.name for record in caplog.records} == {"supple.cli"}
    for record in caplog.records:
        for line in record.getMessage().splitlines():
            assert line.rstrip() in done.output


def test_only_warnings_of_the_library_are_shown_beside_bars(capsys):
    library = logging.getLogger("supple")
    with reported_errors(debug=False):
        say("of a command [not markup]")
        library.info("counting: 3 s")
        library.warning("the disk is nearly full")
    printed = capsys.readouterr().out
    assert printed == "of a command [not markup]\nthe disk is nearly full\n"
    assert not library.handlers
    assert logging.getLogger("supple.cli").level == logging.NOTSET
    say("not within a command")
    assert capsys.readouterr().out == ""
