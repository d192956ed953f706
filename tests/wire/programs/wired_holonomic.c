/* Half-explicit Euler with one constraint: eight Newton steps along the old normal, then a velocity that is tangent. */
#include "sdaeverify.h"
static const char *hello = "name wired-holonomic\nform HolonomicSDAE\nnoise dW\nmost m=1\n"
    "asks force diffused constraint dg inverse_mass\n"
    "claim strong 0.5 source measured\nclaim weak 1.0 source measured\nclaim drift round-off source Newton's method\n";
static long n, P;

static const double *ask(const char *words, const char *name, const double *at) {
    sv_begin(words);
    sv_put(name, at, n, P);
    return sv_ask();
}

static const double *ask_motion(const char *words, const double *w, long l) {
    sv_begin(words);
    sv_put("t", sv_get("t"), -1, 1);
    sv_put("r", sv_get("r"), n, P);
    sv_put("v", sv_get("v"), n, P);
    if (w) sv_put("w", w, l, P);
    return sv_ask();
}

static double product(const double *a, const double *b, long p) {
    double sum = a[p] * b[p];
    for (long i = 1; i < n; i++) sum = sum + a[i * P + p] * b[i * P + p];
    return sum;
}

int main(void) {
    while (sv_next(hello)) {
        const double h = *sv_get("h"), *r = sv_get("r"), *v = sv_get("v"), *mu = sv_get("mu"), *dW = sv_get("dW");
        const double *a, *kick, *push, *normal, *J, *g;
        double *new, *x, *sum, *total;
        long i, p, k, l;
        P = sv_paths("r"), n = sv_size("r") / P, l = sv_size("dW") / P;
        new = (double *)malloc(8 * n * P), x = (double *)malloc(8 * n * P);
        sum = (double *)malloc(8 * n * P), total = (double *)malloc(8 * P);
        normal = ask("ask inverse_mass", "y", ask("ask dg", "r", r));
        for (i = 0; i < n * P; i++) new[i] = r[i] + h * v[i];
        for (k = 0; k < 8; k++) {
            g = ask("ask constraint", "r", new), J = ask("ask dg", "r", new);
            for (p = 0; p < P; p++) {
                double c = g[p] / product(J, normal, p);
                for (i = 0; i < n; i++) new[i * P + p] = new[i * P + p] - normal[i * P + p] * c;
            }
        }
        a = ask_motion("ask force", 0, 0), kick = ask_motion("ask diffused", dW, l);
        for (i = 0; i < n * P; i++) sum[i] = h * a[i] + kick[i];
        push = ask("ask inverse_mass", "y", sum), J = ask("ask dg", "r", new);
        for (i = 0; i < n * P; i++) x[i] = v[i] + push[i];
        for (p = 0; p < P; p++) {
            double lambda = -product(J, x, p) / product(J, normal, p);
            for (i = 0; i < n; i++) x[i * P + p] = x[i * P + p] + normal[i * P + p] * lambda;
            total[p] = mu[p] + lambda;
        }
        sv_begin("done");
        sv_put("r", new, n, P);
        sv_put("v", x, n, P);
        sv_put("mu", total, 1, P);
        sv_send();
        free(new), free(x), free(sum), free(total);
    }
    return 0;
}
