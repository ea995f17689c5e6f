"""What ties the nodes of a part to another: where they meet, and what is equal there."""

from supple.machine.ties.collocated import *
from supple.machine.ties.continuity import *
from supple.machine.ties.mortar import *
from supple.machine.ties.tie import *
