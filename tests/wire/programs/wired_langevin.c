/* Symplectic Euler for Langevin dynamics: p+ = p + h (F(q) - gamma p) + sigma dW, q+ = q + h p+. */
#include "sdaeverify.h"
static const char *hello = "name wired-langevin\nform Langevin\nnoise dW\nasks force\n"
    "claim strong 1.0 source additive noise\nclaim weak 1.0 source measured\n";

int main(void) {
    while (sv_next(hello)) {
        long size = sv_size("x"), P = sv_paths("x"), half = size / 2, i;
        const double h = *sv_get("h"), gamma = *sv_get("friction"), sigma = *sv_get("strength");
        const double *q = sv_get("x"), *p = q + half, *dW = sv_get("dW"), *F;
        double *new = (double *)malloc(8 * size);
        sv_begin("ask force");
        sv_put("q", q, half / P, P);
        F = sv_ask();
        for (i = 0; i < half; i++) {
            new[half + i] = p[i] + h * (F[i] - gamma * p[i]) + sigma * dW[i];
            new[i] = q[i] + h * new[half + i];
        }
        sv_begin("done");
        sv_put("x", new, size / P, P);
        sv_send();
        free(new);
    }
    return 0;
}
