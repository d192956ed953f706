# A solver in Julia for sdaeverify, by version 1 of its wire. Copy this file; it needs Julia's Base alone.
#
# UNTESTED: it was written against the golden transcript on a machine without Julia. Try it with
#     sdaeverify wire --check "julia golden_euler.jl" --golden
#
# On the wire the last axis, of paths, is the fastest; in Julia the first is. So arrays have paths first here: the
# state x of shape d x P on the wire is an array of size (P, d), and a diffusion of shape d x l x P one of (P, l, d).
#
#     include("sdaeverify.jl")
#     serve("name my-euler\nform SDE\nnoise dW\nasks drift diffusion\n") do given, ask
#         t, h, x, dW = given["t"], given["h"][1], given["x"], given["dW"]
#         f, B = ask("drift", "t" => t, "x" => x), ask("diffusion", "t" => t, "x" => x)
#         noise = [sum(B[p, j, i] * dW[p, j] for j in axes(B, 2)) for p in axes(B, 1), i in axes(B, 3)]
#         ["x" => x .+ h .* f .+ noise]
#     end
#
# With "memory" in the hello, the keyword enter = (given, ask) -> ... returns the state that it is given, and the memory
# to begin with.

function read_message(io)
    line = readline(io)
    words = split(line)
    isempty(words) && return "", Dict{String,Array{Float64}}()
    arrays = Dict{String,Array{Float64}}()
    for word in words[2:end]
        name, shape = split(word, "=")
        numbers = Array{Float64}(undef, reverse(parse.(Int, split(shape, "x")))...)
        read!(io, numbers)
        arrays[String(name)] = ltoh.(numbers)
    end
    return String(words[1]), arrays
end

function write_message(io, words, arrays)
    shapes = [string(" ", name, "=", join(reverse(size(numbers)), "x")) for (name, numbers) in arrays]
    write(io, words, shapes..., "\n")
    for (_, numbers) in arrays
        write(io, htol.(Array{Float64}(numbers)))
    end
    flush(io)
end

function serve(step, hello; enter = nothing, input = stdin, output = stdout)
    function ask(name, arrays...)
        write_message(output, "ask " * name, arrays)
        return read_message(input)[2][name]
    end
    while true
        word, given = read_message(input)
        word == "" && return
        if word == "hello"
            write(output, hello)
            write_message(output, "hello", ["version" => [1.0]])
        else
            write_message(output, "done", (word == "enter" ? enter : step)(given, ask))
        end
    end
end
