"""HTTP mechanisms that know nothing of gamuts."""
