"""A seal is broken by any change of the content, and by none of the rest."""

import hashlib

import pytest

from supple.storage.file_seal import seal_matches, sealed

CONTENT = bytes(range(256)) * 5000


@pytest.fixture
def path(tmp_path):
    (tmp_path / "file").write_bytes(sealed(CONTENT))
    return tmp_path / "file"


def test_the_content_stands_first_and_its_digest_behind(path):
    data = path.read_bytes()
    assert data.startswith(CONTENT)
    assert data.endswith(hashlib.sha256(CONTENT).hexdigest().encode())
    assert seal_matches(path)


@pytest.mark.parametrize("place", [0, len(CONTENT) // 2, len(CONTENT) - 1, -1])
def test_a_changed_byte_breaks_it(path, place):
    data = bytearray(path.read_bytes())
    data[place] ^= 1
    path.write_bytes(data)
    assert seal_matches(path) is False


@pytest.mark.parametrize("content", [b"", b"short", CONTENT, sealed(CONTENT)[:-1]])
def test_a_file_without_one_has_none_to_break(path, content):
    path.write_bytes(content)
    assert seal_matches(path) is None


def test_a_byte_lost_from_the_content_breaks_it(path):
    path.write_bytes(path.read_bytes()[1:])
    assert seal_matches(path) is False
