"""Rooms without end: a style and a seed make a room, the same one every time and everywhere.

A style is one file in `worlds/generation/styles` and one line in `worlds/generation/catalogue.py`.
It puts up the shell and says what must be visited; the rest is the same for all: things that leave
a way, a route, things beside the route (`base.py`). What is drawn is rounded to millimetres before
anything is decided, so that the file, the world and the checks are about the same room.
"""
