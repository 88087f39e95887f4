"""The motion that loops allow: degrees of freedom, coordinates, singular positions."""
