"""Gymnasium environments about sonar: tasks, pictures and films."""
