"""Files of results and reduced bodies that stay readable after an interruption."""

from supple.storage.file_name import *
from supple.storage.json_report import *
from supple.storage.reduced_body_hdf5 import *
from supple.storage.result_content import *
from supple.storage.result_file import *
from supple.storage.result_reader import *
