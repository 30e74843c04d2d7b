"""The search for parameters of the sensor model and of HSR, judged by the true score of maps.

`space` tells what may be searched, `settings` what a search is, `drives` the logs it scores,
`search` asks Optuna trial by trial, and `judging` holds the best against the thesis's own
parameters in rooms that the search has never seen.
"""
