"""The search for parameters of the sensor model and of HSR, judged by the true score of maps.

`space` is what may be searched, `settings` what a search is, `scoring` what it goes by; `search`
asks Optuna trial by trial, and `judging` holds the best against the thesis's own parameters in
rooms that the search has never seen.
"""
