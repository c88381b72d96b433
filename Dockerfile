# orasp in a bare Debian 12.
#
#   docker build -t orasp .                        the program
#   docker run --rm orasp solve hubble
#   docker run --rm -v "$PWD":/work orasp solve product.json
#   docker build --target check .                  everything that a change must pass: .ci/run

FROM debian:12 AS source
WORKDIR /orasp
COPY . .

# What a change must pass.
FROM source AS check
RUN .ci/run

# The first run installs the compiler and the libraries, builds the program and solves a problem.
FROM source AS build
RUN ./run solve lattice --quiet && cmake --install build/release --prefix /opt/orasp --strip

# The program, with the libraries and the two programs for drawings that it uses.
FROM debian:12
RUN apt-get -q update \
 && apt-get -q -y install --no-install-recommends libfmt9 libmeshoptimizer2d libmuparser2v5 graphviz gnuplot-nox \
 && rm -rf /var/lib/apt/lists/*
COPY --from=build /opt/orasp /usr/local
WORKDIR /work
ENTRYPOINT ["orasp"]
CMD ["solve", "hubble"]
