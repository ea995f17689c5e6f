"""Controllers: laws that depend on what they read of the machine, in every step or at sampling instants."""

from supple.machine.control.controller import *
from supple.machine.control.readings import *
