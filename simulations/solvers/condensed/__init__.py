"""The condensed Newton step: the elastic body reduced to the compliance of its surface."""
