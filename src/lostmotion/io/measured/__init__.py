"""Files of measurements: a table of named columns with units, and the visits of a robot."""
