"""Begin an arm file: from a template, or a sidecar for a URDF."""
