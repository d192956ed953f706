/* Velocity Verlet with friction and noise in its second kick, which keeps the force of the last step in its memory. */
#include "sdaeverify.h"
static const char *hello = "name wired-verlet\nform Langevin\nnoise dW\nasks force\nmemory n\n"
    "claim strong 1.0 source measured\nclaim weak 1.0 source measured\n";

static const double *force(const double *q, long n, long P) {
    sv_begin("ask force");
    sv_put("q", q, n, P);
    return sv_ask();
}

static void answer(const double *x, const double *memory, long n, long P) {
    sv_begin("done");
    sv_put("x", x, 2 * n, P);
    sv_put("memory", memory, n, P);
    sv_send();
}

int main(void) {
    int task;
    while ((task = sv_next(hello))) {
        long P = sv_paths("x"), half = sv_size("x") / 2, n = half / P, i;
        const double h = *sv_get("h"), gamma = *sv_get("friction"), sigma = *sv_get("strength");
        const double *x = sv_get("x"), *p = x + half, *F, *dW;
        double *new;
        if (task == 2) {
            answer(x, force(x, n, P), n, P);
            continue;
        }
        F = sv_get("memory"), dW = sv_get("dW");
        new = (double *)malloc(8 * 2 * half);
        for (i = 0; i < half; i++) {
            new[half + i] = p[i] + 0.5 * h * F[i];
            new[i] = x[i] + h * new[half + i];
        }
        F = force(new, n, P);
        for (i = 0; i < half; i++) new[half + i] = new[half + i] + 0.5 * h * F[i] - h * gamma * p[i] + sigma * dW[i];
        answer(new, F, n, P);
        free(new);
    }
    return 0;
}
