/* sdaeverify.h: a solver in C, C++ or Fortran for sdaeverify, by version 1 of its wire. Copy it; it needs libc alone.

   int main(void) {
       while (sv_next("name my-euler\nform SDE\nnoise dW\nasks drift\nclaim weak 1 source my paper\n")) {
           long n = sv_size("x"), P = sv_paths("x");        array x of shape n/P x P, paths last: x[i * P + p]
           double *x = sv_get("x"), *new = malloc(n * sizeof *new), *f;
           sv_begin("ask drift"); sv_put("t", sv_get("t"), -1, 1); sv_put("x", x, n / P, P); f = sv_ask();
           ...                                              f is of shape n/P x P, valid until the next sv_next
           sv_begin("done"); sv_put("x", new, n / P, P); sv_send();
       }
   }
   The machine must be little-endian. For Fortran compile it once with -DSV_API= and call the functions by iso_c_binding. */
#ifndef SDAEVERIFY_H
#define SDAEVERIFY_H
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#ifndef SV_API
#define SV_API static inline
#endif
#define SV_MOST 16                                                /* arrays of one message */
typedef struct { char name[64]; long size, paths; double *data; } sv_array;
static sv_array *sv_in;                                           /* of the step, then of the answers to what was asked */
static int sv_ins, sv_outs;
static const double *sv_out[SV_MOST];
static long sv_lengths[SV_MOST];
static char sv_line[4200], sv_word[64];

SV_API void sv_fail(const char *why) { printf("error %s\n", why); fflush(stdout); exit(1); }
SV_API int sv_read(void) {                                        /* 0 where there is no further message */
    int first = sv_ins;
    char *token, *end;
    if (!fgets(sv_line, sizeof sv_line, stdin)) return 0;
    token = strtok(sv_line, " \n");
    snprintf(sv_word, sizeof sv_word, "%s", token ? token : "");
    for (; (token = strtok(NULL, " \n")); sv_ins++) {
        sv_array *a = (sv_in = (sv_array *)realloc(sv_in, (sv_ins + 1) * sizeof *sv_in)) + sv_ins;
        if (!(end = strchr(token, '='))) sv_fail("cannot read the line of a message");
        snprintf(a->name, sizeof a->name, "%.*s", (int)(end - token), token);
        a->size = 1;
        do a->size *= a->paths = strtol(end + 1, &end, 10); while (*end == 'x');
    }
    for (; first < sv_ins; first++) {
        sv_array *a = sv_in + first;
        a->data = (double *)malloc(8 * a->size + 8);
        if (!a->data || fread(a->data, 8, a->size, stdin) != (size_t)a->size) exit(1);
    }
    return 1;
}
SV_API void sv_begin(const char *words) { sv_outs = 0; snprintf(sv_line, sizeof sv_line, "%s", words); }
SV_API void sv_put(const char *name, const double *data, long rows, long paths) {     /* rows < 0: of shape (paths,) */
    size_t n = strlen(sv_line);
    if (sv_outs == SV_MOST) sv_fail("puts more than 16 arrays into a message");
    if (rows < 0) snprintf(sv_line + n, sizeof sv_line - n, " %s=%ld", name, paths);
    else snprintf(sv_line + n, sizeof sv_line - n, " %s=%ldx%ld", name, rows, paths);
    sv_out[sv_outs] = data; sv_lengths[sv_outs++] = rows < 0 ? paths : rows * paths;
}
SV_API void sv_send(void) {
    fputs(sv_line, stdout); putchar('\n');
    for (int i = 0; i < sv_outs; i++) fwrite(sv_out[i], 8, sv_lengths[i], stdout);
    fflush(stdout);
}
SV_API double *sv_ask(void) { int at = sv_ins; sv_send(); if (!sv_read()) exit(1); return sv_in[at].data; }
SV_API sv_array *sv_find(const char *name) {
    for (int i = 0; i < sv_ins; i++) if (!strcmp(sv_in[i].name, name)) return sv_in + i;
    sv_fail("looks for an array that the step has not"); return 0;
}
SV_API double *sv_get(const char *name) { return sv_find(name)->data; }
SV_API long sv_size(const char *name) { return sv_find(name)->size; }
SV_API long sv_paths(const char *name) { return sv_find(name)->paths; }
SV_API int sv_next(const char *hello) {       /* 1 for a step, 2 to enter a state with memory, 0 at the end */
    static const double version = 1.0;
    for (;;) {
        while (sv_ins) free(sv_in[--sv_ins].data);
        if (!sv_read()) return 0;
        if (strcmp(sv_word, "hello")) return strcmp(sv_word, "enter") ? 1 : 2;
        fputs(hello, stdout); sv_begin("hello"); sv_put("version", &version, -1, 1); sv_send();
    }
}
#endif
