"""The case file: its sections with their tables and rules, the case that they describe, and its run."""

from supple.cases.case import *
from supple.cases.examples import *
from supple.cases.modes_case import *
from supple.cases.new_case import *
from supple.cases.read_case import *
from supple.cases.run_case import *
from supple.cases.static_case import *
