"""The costs of a collapse: their parameters, and the kernels that evaluate them."""

from gamutcore.decimation.costs.parameters import COSTS, Cost, Parameters, Trials, cost_named

__all__ = ["COSTS", "Cost", "Parameters", "Trials", "cost_named"]
