"""The command line `sonarbed`: one thin module a command."""
