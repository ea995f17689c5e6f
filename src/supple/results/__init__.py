"""What a simulation leaves behind: recovery, energies, error measures, storage."""
