# syntax=docker/dockerfile:1

# The program, and example robots and scenarios. See docs/ci.md.
FROM rust:1.95-bookworm AS build
WORKDIR /build
COPY . .
# Downloads and compiled crates stay in caches of the builder; the program is copied out of them.
RUN --mount=type=cache,target=/usr/local/cargo/registry \
    --mount=type=cache,target=/build/target \
    cargo build --release --locked --bin runner \
    && cp target/release/runner /usr/local/bin/runner \
    && python3 ci/licences.py "$(rustc --print host-tuple)" > LICENSES-dependencies.txt

# Jobs of GitLab and GitHub need a shell in their image, so it is not distroless. It has libstdc++ and libgcc, as apt
# needs them, of the Debian that the program is linked with.
FROM debian:bookworm-slim
LABEL org.opencontainers.image.title="stiction" \
      org.opencontainers.image.description="Scenario runner for legged-robot contact" \
      org.opencontainers.image.licenses="MIT OR Apache-2.0"
COPY --from=build /usr/local/bin/runner /usr/local/bin/runner
COPY LICENSE-MIT LICENSE-APACHE /usr/share/doc/stiction/
COPY src/view/page/three/LICENSE /usr/share/doc/stiction/LICENSE-three.js
COPY --from=build /build/LICENSES-dependencies.txt /usr/share/doc/stiction/
COPY robots /usr/share/stiction/robots
COPY scenarios /usr/share/stiction/scenarios
# Fails where a shared library is missing. The user can write in /work only.
RUN runner --version \
    && useradd --uid 10001 --user-group --no-create-home --shell /usr/sbin/nologin stiction \
    && install --directory --owner stiction --group stiction /work
USER 10001:10001
WORKDIR /work
VOLUME /work
ENTRYPOINT ["runner"]
CMD ["--help"]
