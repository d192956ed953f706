/* A program that returns the state it was given: what a step costs without any arithmetic. */
#include "sdaeverify.h"

int main(void) {
    while (sv_next("name wired-keep\nform SDE\nnoise dW\n")) {
        sv_begin("done");
        sv_put("x", sv_get("x"), sv_size("x") / sv_paths("x"), sv_paths("x"));
        sv_send();
    }
    return 0;
}
