"""Transition operator of a scheme on a chart: errors of means without sampling."""
