"""What is found out with the testbed: a folder a study, all with the kit of `reporting`."""
