#!/usr/bin/env python3
"""SIGHUP with a renewed certificate, another token and another configuration; and with mistakes in them."""
import os, shutil, signal, ssl, subprocess
from support import Server, Viewer, check, connect, finish, program, until


def certificate(folder, name):
    subprocess.run([program('openssl'), 'req', '-x509', '-newkey', 'ec', '-pkeyopt', 'ec_paramgen_curve:P-256', '-nodes', '-days', '2',
                    '-subj', '/CN=' + name, '-keyout', folder + '/key.pem', '-out', folder + '/cert.pem'], check=True, capture_output=True)


def shown(server):
    with connect(server.port, 'https') as s:
        return ssl.DER_cert_to_PEM_cert(s.getpeercert(True))


def on_disk(folder):
    with open(folder + '/cert.pem') as f:
        return f.read()


def main():
    openssl = program('openssl')
    work = subprocess.run(['mktemp', '-d'], capture_output=True, text=True).stdout.strip()
    certificate(work, 'first')
    with open(work + '/token', 'w') as f:
        f.write('the first token 0123456789\n')
    with open(work + '/heliograph.toml', 'w') as f:
        f.write("tls-cert = '%s/cert.pem'\ntls-key = '%s/key.pem'\ntoken-file = '%s/token'\nmax-viewers = 5\n" % (work, work, work))
    server = Server('--config', work + '/heliograph.toml', scheme='https')
    bearer = lambda token: ['Authorization: Bearer ' + token]
    check('the first certificate is shown', shown(server).strip() == on_disk(work).strip())
    viewer = Viewer(server.port, 'https', headers=bearer('the first token 0123456789'))
    viewer.read(20, lambda: viewer.inputs)
    certificate(work, 'second')
    with open(work + '/token', 'w') as f:
        f.write('the second token 0123456789\n')
    with open(work + '/heliograph.toml', 'a') as f:
        f.write("client = '/elsewhere'\n")
    server.send(signal.SIGHUP)
    check('SIGHUP: the renewed certificate is shown', bool(until(lambda: shown(server).strip() == on_disk(work).strip(), 5)))
    check('... the new token is asked for', server.get('/metrics', bearer('the first token 0123456789'))[0] == 401)
    check('... and taken', server.get('/metrics', bearer('the second token 0123456789'))[0] == 200)
    viewer.camera(2)
    viewer.read(10, lambda: 2 in viewer.inputs)
    check('... the viewer who was there stays', viewer.inputs[-1] == 2)
    with open(work + '/heliograph.toml', 'a') as f:
        f.write('max-viewers = 0\n')
    server.send(signal.SIGHUP)
    check('a mistake is said, with its line', bool(until(lambda: 'not reloaded, all stays as it was: %s/heliograph.toml:' % work in server.log(), 5)))
    check('... and all stays', server.get('/metrics', bearer('the second token 0123456789'))[0] == 200)
    code, _ = server.end()
    check('exit code 0', code == 0, code)
    shutil.rmtree(work)


if __name__ == '__main__':
    main()
    finish()
