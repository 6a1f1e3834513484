# terrabite on Debian 12, with Debian's GDAL:
#
#     docker build -t terrabite .
#     docker run --rm -v "$PWD:/data" terrabite simplify dem.tif tin.ply --max-error 5

FROM rust:1-bookworm AS build
RUN apt-get update -qq \
    && apt-get install -y -qq --no-install-recommends g++ libgdal-dev pkg-config
WORKDIR /terrabite
COPY . .
RUN cargo install --locked --path . --root /usr/local

FROM debian:bookworm-slim
RUN apt-get update -qq \
    && apt-get install -y -qq --no-install-recommends ca-certificates libgdal32 \
    && rm -rf /var/lib/apt/lists/*
COPY --from=build /usr/local/bin/terrabite /usr/local/bin/terrabite
WORKDIR /data
ENTRYPOINT ["terrabite"]
