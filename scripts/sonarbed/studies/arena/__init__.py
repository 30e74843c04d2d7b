"""The arena: every mapping method and reading filter on the same logs, judged by truth.

A drive is simulated once (`DriveJob`); each entry, a filter and a method, maps it in a run of its
own (`RunJob`), which leaves one row. Entries get logs without truth and provenance, on a grid that
gives no wall away; only the oracles among the filters know more.
"""
