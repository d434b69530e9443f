"""Conditional logit: the probability of each candidate of a pair, and of none, fitted by maximum likelihood.

Of all candidates and of "none", each is right with a probability in proportion to its odds, "none" having odds of one.
The log-odds of a candidate are a weighted sum of its terms, or a floor where that is higher. The likelihood, with a
penalty on large weights, is maximised by Adam (Kingma and Ba, arXiv:1412.6980).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

STEPS, RATE = 1500, 0.02
PENALTY = 2e-4  # of squared weights of standardised terms


@dataclass(frozen=True, slots=True, eq=False)
class Choices:
    """Candidates of P pairs, up to K each.

    Parameters
    ----------
    terms
        Shape (P, K, T); the first term is the constant.
    is_there, is_right
        Shape (P, K): entries that hold a candidate, and right candidates.
    floor
        Shape (P, K): other log-odds, to which the odds of the weighted sum are added; minus infinity for none.
    offset
        Shape (P, 1): added to the weighted sums of a pair.
    """

    terms: NDArray[np.float64]
    is_there: NDArray[np.bool_]
    is_right: NDArray[np.bool_]
    floor: NDArray[np.float64]
    offset: NDArray[np.float64]

    def log_odds(self, weights: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the log-odds of each candidate, shape (P, K); minus infinity where there is none."""
        odds = np.logaddexp(self.floor, self.terms @ weights + self.offset)
        return np.where(self.is_there, odds, -np.inf)

    def loss(self, weights: NDArray[np.float64]) -> float:
        """Return the mean negative log-likelihood of the right candidates, nats per pair."""
        posterior = posterior_of(self.log_odds(weights))
        right = (posterior * self.is_right).sum(axis=1)
        likelihood = np.where(self.is_right.any(axis=1), right, 1 - posterior.sum(axis=1))
        return float(-np.log(np.maximum(likelihood, 1e-12)).mean())


def fit(choices: Choices, signs: NDArray[np.int_]) -> NDArray[np.float64]:
    """Fit the weights, shape (T,), each of its sign in `signs` (0: any) or zero; only the constant is not shrunk."""
    spread = choices.terms[choices.is_there].std(axis=0)
    spread[spread < 1e-9] = 1.0  # such as the constant
    terms = choices.terms / spread
    shrunk = np.array([0.0, *np.ones(len(signs) - 1)])

    def gradient(weights: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(_gradient(choices, terms, weights) + 2 * PENALTY * weights * shrunk)

    fitted: NDArray[np.float64] = ascend(gradient, signs) / spread
    return fitted


def ascend(
    gradient: Callable[[NDArray[np.float64]], NDArray[np.float64]], signs: NDArray[np.int_]
) -> NDArray[np.float64]:
    """Maximise a likelihood by the gradient of its negative logarithm; each weight is of its sign or zero."""
    weights: NDArray[np.float64] = np.zeros(len(signs))
    mean, square = np.zeros((2, len(signs)))
    for step in range(1, STEPS + 1):
        slope = gradient(weights)
        mean, square = 0.9 * mean + 0.1 * slope, 0.999 * square + 0.001 * slope**2
        weights = weights - RATE * (mean / (1 - 0.9**step)) / (np.sqrt(square / (1 - 0.999**step)) + 1e-9)
        weights = np.where(weights * signs < 0, 0.0, weights)
    return weights


def posterior_of(log_odds: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the probability of each candidate, shape (P, K), from log-odds against "none"."""
    top = np.maximum(log_odds.max(axis=1, keepdims=True), 0.0)
    raised = np.exp(log_odds - top)
    posterior: NDArray[np.float64] = raised / (raised.sum(axis=1, keepdims=True) + np.exp(-top))
    return posterior


def _gradient(choices: Choices, terms: NDArray[np.float64], weights: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the gradient of the mean negative log-likelihood in the weights of the scaled terms, shape (T,)."""
    own = terms @ weights + choices.offset
    odds = np.where(choices.is_there, np.logaddexp(choices.floor, own), -np.inf)
    posterior = posterior_of(odds)
    right = posterior * choices.is_right
    wanted = right / np.maximum(right.sum(axis=1, keepdims=True), 1e-300)
    share = np.exp(np.where(choices.is_there, own - odds, -np.inf))  # of the odds that is the weighted sum's
    gradient: NDArray[np.float64] = np.einsum("pk,pkt->t", (posterior - wanted) * share, terms) / len(terms)
    return gradient
