"""The modified equation of a scheme: the SDE that one step solves to one order more, from elementary weights.

With defects Delta(F) = found - wanted of the means of forests, and the generator L of the equation, a step satisfies

    E u(X_1) = exp(h L) u + sum over forests F of  Delta(F)/sigma(F) h^(w/2) D^n u(F(tau_1), ..., F(tau_n)),

where sigma is the symmetry of the forest and n its number of trees. At weak order p the sum begins with the weight
w = 2 p + 2 and equals h^(p + 1) L_p u to leading order, so that the step is exp(h (L + h^p L_p)) to one order more.
Forests of one tree give the drift h^p f_p, those of two trees the covariance h^p Q_p. The generator of an SDE has no
derivatives of third or higher order: with such forests, no modified SDE exists in the weak sense at that order.

Shardlow 2006; Zygalakis 2011; Abdulle, Cohen, Vilmart & Zygalakis 2012; Debussche & Faou 2012.
"""
