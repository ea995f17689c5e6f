"""Case files of explicit runs: parts instead of bodies, one file per section."""
